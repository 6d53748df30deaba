# Writes the version and the state of the sources (git describe) into OUTPUT; untouched when nothing changed.
#   cmake -DOUTPUT=FILE -DVERSION=X.Y.Z -DSOURCE=DIR -P version.cmake
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=10
  OUTPUT_VARIABLE revision ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
set(version "${VERSION}")
if(revision)
  string(APPEND version " (${revision})")
endif()
set(text "#include \"app/cli/options.h\"

std::string gpvc::cli::program_version() { return \"${version}\"; }
")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
