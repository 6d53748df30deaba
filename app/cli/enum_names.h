// Names of the enums of the libraries, as options and run.json spell them.
#pragma once

#include "io/io.h"
#include "io/names.h"
#include "visibility/visibility.h"

namespace gpvc::io {

inline constexpr Named<ImageFormat> kImageFormatNames[] = {{"jpg", ImageFormat::jpg}, {"png", ImageFormat::png}};
inline constexpr Named<UpAxis> kUpAxisNames[] = {{"+x", UpAxis::pos_x}, {"-x", UpAxis::neg_x}, {"+y", UpAxis::pos_y},
                                                 {"-y", UpAxis::neg_y}, {"+z", UpAxis::pos_z}, {"-z", UpAxis::neg_z}};
inline constexpr Named<GltfContainer> kGltfContainerNames[] = {{"glb", GltfContainer::glb},
                                                               {"files", GltfContainer::files}};
inline constexpr Named<SceneTarget> kSceneTargetNames[] = {
    {"colmap", SceneTarget::colmap}, {"cam", SceneTarget::cam}, {"mvs", SceneTarget::mvs}};

}  // namespace gpvc::io

namespace gpvc::visibility {

inline constexpr Named<Projection> kProjectionNames[] = {{"apc", Projection::apc}, {"spc", Projection::spc}};
inline constexpr Named<CoverageCorrection> kCoverageCorrectionNames[] = {
    {"off", CoverageCorrection::off}, {"paper", CoverageCorrection::paper}, {"exact", CoverageCorrection::exact}};
inline constexpr Named<Classifier> kClassifierNames[] = {
    {"auto", Classifier::automatic}, {"cpu", Classifier::cpu}, {"gpu", Classifier::gpu}};
inline constexpr Named<Drawing> kDrawingNames[] = {
    {"auto", Drawing::automatic}, {"opengl", Drawing::opengl}, {"native", Drawing::native}};

}  // namespace gpvc::visibility
