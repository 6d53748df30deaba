// Where the program's large blocks of memory are.
#pragma once

#include <filesystem>

namespace gpvc::cli {

/// From now on blocks of 16 MB and more lie in files without names in a folder, mapped into memory: what is larger than the
/// memory is there all the same, and the system moves what is not in use to disk. Slower where there is memory enough. Blocks
/// that cannot be had there are ordinary ones. Without effect in builds with sanitizers, which have memory of their own.
void keep_large_blocks_in(const std::filesystem::path& folder);

}  // namespace gpvc::cli
