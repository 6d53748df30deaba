#include "app/cli/memory_arenas.h"
#include "app/texrecon/texrecon.h"

int main(int argc, char** argv) {
  gpvc::cli::set_memory_arenas();
  return gpvc::texrecon::run_command_line(argc, argv);
}
