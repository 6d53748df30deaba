#include "app/cli/app.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Blocks of a megabyte and more go back to the system when they are freed. By default glibc keeps freed blocks of up to
  // 32 MB, in as many arenas as there are threads, for hundreds of megabytes that nothing uses.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
  return gpvc::cli::run_command_line(argc, argv);
}
