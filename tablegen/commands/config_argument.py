"""Arguments and options that take a configuration: a material pair or a scene."""

from sampler.options import Named
from tablegen.config.config_files import config_files

#: Name or path of a configuration. What it is read from, the pair and the meshes that it names
#: included, is not written to.
CONFIG = Named(".toml", config_files)
