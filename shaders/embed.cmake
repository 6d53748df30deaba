# Writes the shader files as one C++ source that defines gpvc::shader_source().
#   cmake -DOUTPUT=FILE.cpp "-DFILES=a.vert;b.frag" -P embed.cmake
# A string literal may hold 64 KiB portably; each file is one raw literal, so files stay below that.
set(entries "")
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  file(READ ${file} text)
  string(LENGTH "${text}" length)
  if(length GREATER 60000)
    message(FATAL_ERROR "${file} has ${length} bytes, too many for one string literal")
  endif()
  string(APPEND entries "    {\"${name}\", R\"SHADER(${text})SHADER\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by shaders/embed.cmake.
#include <stdexcept>
#include <string>
#include <utility>

#include \"visibility/gl/gl_objects.h\"

namespace gpvc::visibility {
namespace {

constexpr std::pair<std::string_view, std::string_view> kShaders[] = {
${entries}};

}  // namespace

std::string_view shader_source(std::string_view file) {
  for (const auto& [name, text] : kShaders)
    if (name == file) return text;
  throw std::logic_error(\"no shader is called \" + std::string(file));
}

}  // namespace gpvc::visibility
")
