// For programs whose operator new is not that of large_blocks.cpp: tests, and builds with sanitizers.
#include "app/cli/large_blocks.h"

namespace gpvc::cli {

[[gnu::weak]] void keep_large_blocks_in(const std::filesystem::path& /*folder*/) {}

}  // namespace gpvc::cli
