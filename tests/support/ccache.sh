# Sourced by scripts that compile, with the tree's place in root.
# ccache finds out what a source includes from the compiler, without a run of the preprocessor. It serves any folder that
# this tree lies in, but unity sources, which name theirs by whole paths, in the folder alone that they were compiled in.
# Precompiled headers need the sloppiness: ccache cannot see which macros they look at.
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1 CCACHE_DEPEND=1 CCACHE_SLOPPINESS=pch_defines,time_macros
# Empty where there is no ccache: CMake then keeps none either.
with_ccache="-DCMAKE_CXX_COMPILER_LAUNCHER=$(command -v ccache || true)"
