#include "app/cli/app.h"

int main(int argc, char** argv) { return gpvc::cli::run_command_line(argc, argv); }
