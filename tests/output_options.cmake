# Options about photos and outputs, on the same scene.
find_package(OpenMesh REQUIRED)
add_executable(output_options_test output_options_test.cpp)
target_link_libraries(output_options_test PRIVATE gpvc_app gpvc_options OpenMeshCore GTest::gtest_main)
# See gltf_files_test in io.cmake.
target_compile_options(output_options_test PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
target_compile_definitions(output_options_test PRIVATE GPVC_BINARY="$<TARGET_FILE:gpvc>" GPVC_APP_SCENE="${app_scene}")
add_dependencies(output_options_test gpvc)
gtest_discover_tests(output_options_test DISCOVERY_TIMEOUT 60
  PROPERTIES LABELS gpu TIMEOUT 600 FIXTURES_REQUIRED app_scene)
