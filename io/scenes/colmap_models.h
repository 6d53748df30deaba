// COLMAP's camera models: https://colmap.github.io/cameras.html
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "io/scene.h"

namespace gpvc::io {

using DistortionTerm = double Distortion::*;

/// Parameters are the focal lengths (one f, or fx and fy), cx, cy and the terms, in this order.
struct ColmapModel {
  std::string_view name;
  std::size_t focal_lengths = 0;  ///< 0: of panoramas, whose parameters are width and height
  LensModel lens = LensModel::perspective;
  std::array<DistortionTerm, 12> all_terms{};  ///< null behind the last

  std::span<const DistortionTerm> terms() const {
    return {all_terms.begin(), std::find(all_terms.begin(), all_terms.end(), nullptr)};
  }
  std::size_t parameters() const { return focal_lengths + 2 + terms().size(); }
};

namespace colmap_terms {

using D = Distortion;
inline constexpr DistortionTerm k1 = &D::k1, k2 = &D::k2, k3 = &D::k3, k4 = &D::k4, k5 = &D::k5, k6 = &D::k6,
                                p1 = &D::p1, p2 = &D::p2, d1 = &D::d1, d2 = &D::d2, d3 = &D::d3, s1 = &D::s1,
                                s2 = &D::s2, s3 = &D::s3, s4 = &D::s4;

/// In the order of their numbers. SIMPLE_FISHEYE and FISHEYE are equidistant without terms; no model is equisolid.
inline constexpr std::array<ColmapModel, 18> kModels{{
    {"SIMPLE_PINHOLE", 1, LensModel::perspective, {}},
    {"PINHOLE", 2, LensModel::perspective, {}},
    {"SIMPLE_RADIAL", 1, LensModel::perspective, {k1}},
    {"RADIAL", 1, LensModel::perspective, {k1, k2}},
    {"OPENCV", 2, LensModel::perspective, {k1, k2, p1, p2}},
    {"OPENCV_FISHEYE", 2, LensModel::equidistant, {k1, k2, k3, k4}},
    {"FULL_OPENCV", 2, LensModel::perspective, {k1, k2, p1, p2, k3, d1, d2, d3}},
    {"FOV", 2, LensModel::fov, {&D::omega}},
    {"SIMPLE_RADIAL_FISHEYE", 1, LensModel::equidistant, {k1}},
    {"RADIAL_FISHEYE", 1, LensModel::equidistant, {k1, k2}},
    {"THIN_PRISM_FISHEYE", 2, LensModel::equidistant, {k1, k2, p1, p2, k3, k4, s1, s2}},
    {"RAD_TAN_THIN_PRISM_FISHEYE", 2, LensModel::fisheye_624, {k1, k2, k3, k4, k5, k6, p2, p1, s1, s3, s2, s4}},
    {"SIMPLE_DIVISION", 1, LensModel::division, {k1}},
    {"DIVISION", 2, LensModel::division, {k1}},
    {"SIMPLE_FISHEYE", 1, LensModel::equidistant, {}},
    {"FISHEYE", 2, LensModel::equidistant, {}},
    {"EUCM", 2, LensModel::unified, {&D::alpha, &D::beta}},
    {"EQUIRECTANGULAR", 0, LensModel::spherical, {}},
}};

}  // namespace colmap_terms

inline constexpr const std::array<ColmapModel, 18>& kColmapModels = colmap_terms::kModels;

}  // namespace gpvc::io
