#include "app/cli/app.h"
#include "app/cli/memory_arenas.h"

int main(int argc, char** argv) {
  gpvc::cli::set_memory_arenas();
  return gpvc::cli::run_command_line(argc, argv);
}
