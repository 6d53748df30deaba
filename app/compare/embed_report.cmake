# Writes report.html as a C++ source that defines gpvc::kReportTemplate.
#   cmake -DOUTPUT=FILE.cpp -DFILE=report.html -P embed_report.cmake
# A string literal may hold 64 KiB portably, so the file stays below that.
file(READ ${FILE} text)
string(LENGTH "${text}" length)
if(length GREATER 60000)
  message(FATAL_ERROR "${FILE} has ${length} bytes, too many for one string literal")
endif()
file(WRITE ${OUTPUT} "// Made by app/compare/embed_report.cmake.
#include \"app/compare/compare_report.h\"

namespace gpvc::compare {

const char* const kReportTemplate = R\"REPORT(${text})REPORT\";

}  // namespace gpvc::compare
")
