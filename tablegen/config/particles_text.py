"""A population in one line, from its table in a file. Unlike records, this loads fast."""

from tablegen.config.scenes import Tree


def particles_text(population: Tree) -> str:
    """Say which particles a population has: shares of shapes and meshes, and the aspect ratios."""
    weights = {
        name: weight for name, weight in population.get("shapes", {}).items() if weight > 0.0
    }
    meshes = population.get("meshes", ())
    shares = [(mesh.get("file") or "a mesh", mesh.get("weight", 1.0)) for mesh in meshes]
    parts = [*weights.items(), *(share for share in shares if share[1] > 0.0)]
    total = sum(weight for _, weight in parts)
    text = ", ".join(f"{100.0 * weight / total:.3g} % {name}" for name, weight in parts)
    aspect = population.get("aspect")
    if not aspect or not weights.keys() - {"sphere"}:
        return text
    if "values" in aspect:
        return text + "; b/a {:g}, c/b {:g}".format(*aspect["values"])
    law = f"{aspect['mean']:g} ± {aspect['standard_deviation']:g}"
    return text + f"; b/a and c/b {law}, cut to " + "{:g} to {:g}".format(*aspect["range"])
