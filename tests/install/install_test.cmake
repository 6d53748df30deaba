# Installs the build into an empty folder, builds outsider.cpp against what lies there, runs it on a scene whose photos it
# holds in memory, and compares what it wrote with what `gpvc texture` wrote, byte for byte.
#   cmake -DBUILD=DIR -DSOURCE=tests/install -DSCRATCH=DIR -DCITY=DIR -DEXPECTED=DIR -DBUILD_TYPE=Release
#         -DGENERATOR=Ninja -DCXX_COMPILER=c++ -DCXX_FLAGS= -P install_test.cmake
file(REMOVE_RECURSE ${SCRATCH})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${SCRATCH}/prefix)
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${SOURCE} -B ${SCRATCH}/build -DCMAKE_PREFIX_PATH=${SCRATCH}/prefix
    -DCMAKE_BUILD_TYPE=${BUILD_TYPE} -DCMAKE_CXX_COMPILER=${CXX_COMPILER} -DCMAKE_CXX_FLAGS=${CXX_FLAGS})
run(${CMAKE_COMMAND} --build ${SCRATCH}/build)
run(${SCRATCH}/build/outsider ${CITY}/colmap ${CITY}/mesh.ply ${SCRATCH}/textured)
foreach(file labels.npy tags.npy faces.npy model.obj model.mtl model_0.jpg model.glb preview.png)
  run(${CMAKE_COMMAND} -E compare_files ${EXPECTED}/${file} ${SCRATCH}/textured/${file})
endforeach()
file(GLOB written RELATIVE ${SCRATCH}/prefix LIST_DIRECTORIES false ${SCRATCH}/prefix/include/*)
if(written)
  message(FATAL_ERROR "headers outside include/gpvc: ${written}")
endif()
