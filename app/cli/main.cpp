#include <algorithm>
#include <thread>

#include "app/cli/app.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Blocks of a megabyte and more go back to the system when they are freed, and there is an arena a core for smaller
  // ones. By default glibc keeps freed blocks of up to 32 MB, in eight arenas a core, for hundreds of megabytes that
  // nothing uses.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  mallopt(M_ARENA_MAX, static_cast<int>(std::max(2u, std::thread::hardware_concurrency())));
#endif
  return gpvc::cli::run_command_line(argc, argv);
}
