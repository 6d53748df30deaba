# Writes report.html, with the files that it names in place of their names, as a C++ source that defines
# gpvc::kReportTemplate.
#   cmake -DOUTPUT=FILE.cpp -P embed_report.cmake
# A string literal may hold 64 KiB portably, so the page stays below that.
file(READ ${CMAKE_CURRENT_LIST_DIR}/report.html text)
foreach(part report.css report.js)
  file(READ ${CMAKE_CURRENT_LIST_DIR}/${part} content)
  string(REPLACE "/*${part}*/" "${content}" text "${text}")
endforeach()
string(LENGTH "${text}" length)
if(length GREATER 60000)
  message(FATAL_ERROR "report.html has ${length} bytes, too many for one string literal")
endif()
file(WRITE ${OUTPUT} "// Made by app/compare/embed_report.cmake.
#include \"app/compare/compare_report.h\"

namespace gpvc::compare {

const char* const kReportTemplate = R\"REPORT(${text})REPORT\";

}  // namespace gpvc::compare
")
