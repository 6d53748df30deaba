// Names of the enums of the libraries, as options and run.json spell them.
#pragma once

#include "io/names.h"
#include "io/scene_files.h"
#include "io/textured_model.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {

inline constexpr Named<Projection> kProjectionNames[] = {{"apc", Projection::apc}, {"spc", Projection::spc}};
inline constexpr Named<CoverageCorrection> kCoverageCorrectionNames[] = {
    {"off", CoverageCorrection::off}, {"paper", CoverageCorrection::paper}, {"exact", CoverageCorrection::exact}};
inline constexpr Named<Classifier> kClassifierNames[] = {
    {"auto", Classifier::automatic}, {"cpu", Classifier::cpu}, {"gpu", Classifier::gpu}};
inline constexpr Named<Drawing> kDrawingNames[] = {
    {"auto", Drawing::automatic}, {"opengl", Drawing::opengl}, {"native", Drawing::native}};

}  // namespace gpvc::visibility
