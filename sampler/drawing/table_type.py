"""The type that a table's arrays have in compiled code: one value, with the fields as attributes.

To numba a `TableArrays` would be a tuple of tuples. That serves but in a parallel loop (`prange`):
numba hands a tuple to its threads field by field, and refuses fields that are tuples again. A
structure it hands over whole.

Importing this file is enough; every kernel that gets a table is in a file that does.
"""

from typing import Any

from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_constant
from numba.extending import (
    NativeValue,
    box,
    make_attribute_wrapper,
    models,
    register_model,
    typeof_impl,
    unbox,
)

from sampler.formats.bounds import TableArrays


class TableType(types.Type):
    """Type of a `TableArrays`, by that of the tuple."""

    def __init__(self, whole: types.NamedTuple) -> None:
        self.whole = whole
        super().__init__(name=f"table of {whole}")

    @property
    def key(self) -> types.NamedTuple:
        """What tells two such types apart."""
        return self.whole


@typeof_impl.register(TableArrays)
def _type_of(arrays: TableArrays, context: Any) -> TableType:
    parts = tuple(typeof_impl(field, context) for field in arrays)
    return TableType(types.NamedTuple(parts, TableArrays))


@register_model(TableType)
class _TableModel(models.StructModel):
    def __init__(self, manager: Any, kind: TableType) -> None:
        super().__init__(manager, kind, list(zip(TableArrays._fields, kind.whole, strict=True)))


for _name in TableArrays._fields:
    make_attribute_wrapper(TableType, _name, _name)


def _structure(context: Any, builder: Any, kind: TableType, fields: Any) -> Any:
    """Value of a table from those of its fields."""
    made = cgutils.create_struct_proxy(kind)(context, builder)
    for name, field in zip(TableArrays._fields, fields, strict=True):
        setattr(made, name, field)
    return made._getvalue()


@unbox(TableType)
def _from_python(kind: TableType, arrays: Any, c: Any) -> NativeValue:
    whole = c.unbox(kind.whole, arrays)
    fields = [c.builder.extract_value(whole.value, k) for k in range(len(kind.whole))]
    value = _structure(c.context, c.builder, kind, fields)
    return NativeValue(value, is_error=whole.is_error, cleanup=whole.cleanup)


@box(TableType)
def _to_python(kind: TableType, value: Any, c: Any) -> Any:
    made = cgutils.create_struct_proxy(kind)(c.context, c.builder, value)
    fields = [getattr(made, name) for name in TableArrays._fields]
    return c.box(kind.whole, c.context.make_tuple(c.builder, kind.whole, fields))


@lower_constant(TableType)
def _global(context: Any, builder: Any, kind: TableType, arrays: TableArrays) -> Any:
    pairs = zip(kind.whole, arrays, strict=True)
    fields = [context.get_constant_generic(builder, part, field) for part, field in pairs]
    return _structure(context, builder, kind, fields)
