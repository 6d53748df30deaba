#include "app/cli/app.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Blocks of a megabyte and more go back to the system when they are freed, and threads share the memory of smaller ones.
  // By default glibc keeps freed blocks of up to 32 MB, in arenas of the threads, for hundreds of megabytes that nothing
  // uses.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  mallopt(M_ARENA_MAX, 2);
#endif
  return gpvc::cli::run_command_line(argc, argv);
}
