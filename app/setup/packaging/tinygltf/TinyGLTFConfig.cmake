# TinyGLTF::TinyGLTF where it comes as a header alone, as from vcpkg and from its sources: compiled here, without the pictures
# that it could decode. -DTinyGLTF_DIR=app/setup/packaging/tinygltf, with BUILD_SHARED_LIBS, of which it is a private part.
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h PATH_SUFFIXES tinygltf REQUIRED)
if(NOT TARGET TinyGLTF::TinyGLTF)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/tiny_gltf.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "#define TINYGLTF_IMPLEMENTATION\n#include <tiny_gltf.h>\n")
  add_library(tinygltf STATIC ${source})
  target_include_directories(tinygltf SYSTEM PUBLIC ${TINYGLTF_INCLUDE_DIR})
  # Members of its class depend on them.
  target_compile_definitions(tinygltf PUBLIC TINYGLTF_NO_STB_IMAGE TINYGLTF_NO_STB_IMAGE_WRITE)
  target_compile_features(tinygltf PUBLIC cxx_std_17)
  find_package(nlohmann_json REQUIRED)
  target_link_libraries(tinygltf PRIVATE nlohmann_json::nlohmann_json)
  add_library(TinyGLTF::TinyGLTF ALIAS tinygltf)
endif()
set(TinyGLTF_FOUND TRUE)
