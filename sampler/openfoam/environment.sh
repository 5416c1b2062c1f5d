# Sourced by the scripts beside it: where OpenFOAM v1912 of the Debian packages and what wmake needs
# to build against it are. FOLDER is the working folder.
#
# The packages hold programs and libraries but no headers and no wmake; those come from the source
# package, built as its debian/rules says (32-bit labels, double precision). We link against /usr/lib.

export WM_PROJECT=OpenFOAM
export WM_PROJECT_VERSION=1912
export WM_PROJECT_DIR="$FOLDER/openfoam-1912.200626"
export WM_DIR="$WM_PROJECT_DIR/wmake"
export WM_ARCH=linux64
export WM_OPTIONS=linux64Gcc
export WM_COMPILER=Gcc
export WM_COMPILER_LIB_ARCH=64
export WM_COMPILE_OPTION=Opt
export WM_LABEL_SIZE=32
export WM_LABEL_OPTION=Int32
export WM_PRECISION_OPTION=DP
export WM_MPLIB=SYSTEMOPENMPI
export FOAM_MPI=openmpi-system
export FOAM_SRC="$WM_PROJECT_DIR/src"
export FOAM_ETC="$WM_PROJECT_DIR/etc"
export FOAM_APPBIN=/usr/bin
export FOAM_LIBBIN=/usr/lib
export FOAM_EXT_LIBBIN=/usr/lib
export FOAM_USER_LIBBIN="$FOLDER/lib"
export PATH="$WM_DIR:$PATH"
export LD_LIBRARY_PATH="$FOAM_USER_LIBBIN${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"

# Open MPI asks root for these, and counts the cores of a container differently from us.
export OMPI_ALLOW_RUN_AS_ROOT=1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1
