# What runs under the thread sanitizer: threads_PROGRAM is the GTEST_FILTER of a test program. Left out are tests of
# minutes, whose loops shorter ones run as well, and programs without a line here: visibility_gl_tests mostly waits for
# llvmpipe, which is not instrumented, and program_gl_tests starts other processes.
set(threads_io_tests "*")
set(threads_visibility_tests
    "-CpuIvm.OnlyFacesThatCover*:CpuIvm.SliversAndFaces*:Oracle.AgreesWithRays*:QuickFace.*:Raster.*:\
Stage.MovingTheScene*")
set(threads_labeling_tests "-Labeling.EnergyNeverRises*:Labeling.FastIsCloseToThorough*")
set(threads_atlas_tests "-Mips.*:SeamLeveling.VignettingIsRemoved")
# The sanitizer ends a process that starts threads after it was forked off, as those of Interrupt do.
set(threads_app_tests
    "-Interrupt.*:TruthOfACity.WhatMasks*:TruthOfACity.GoodModel*:TruthOfACity.WrongColors*:\
TruthOfACity.Origins*:TruthOfACity.Ghosts*")
# The whole pipeline: views seen while costs are computed, meshes judged, pages written, work kept and taken over.
set(threads_app_gl_tests "CheckpointTest.*:Pipeline.*-CheckpointTest.OtherOptions*:CheckpointTest.AnotherPhoto*")

# tests/run.sh --threads builds this.
add_custom_target(threads_tests)

# Without a report of this one, the silence of the others says nothing.
add_executable(race threads/race.cpp)
target_link_libraries(race PRIVATE gpvc_options)
add_test(NAME threads.race_is_found COMMAND race)
set_tests_properties(threads.race_is_found PROPERTIES
  PASS_REGULAR_EXPRESSION "ThreadSanitizer: data race" LABELS threads)
add_dependencies(threads_tests race)
