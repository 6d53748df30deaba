#include "app/app.h"

int main(int argc, char** argv) { return gpvc::run_command_line(argc, argv); }
