// Names of lens models and of the terms of a lens, as files and messages write them.
#pragma once

#include <cstddef>
#include <span>

#include "names.h"
#include "scene.h"

namespace gpvc {

struct LensTerm {
  const char* name;
  double Distortion::*term;
};

/// All terms of Distortion; those of LensModel::brown come first.
inline constexpr LensTerm kLensTerms[] = {
    {"k1", &Distortion::k1}, {"k2", &Distortion::k2},       {"p1", &Distortion::p1},
    {"p2", &Distortion::p2}, {"k3", &Distortion::k3},       {"k4", &Distortion::k4},
    {"d1", &Distortion::d1}, {"d2", &Distortion::d2},       {"d3", &Distortion::d3},
    {"p3", &Distortion::p3}, {"p4", &Distortion::p4},       {"s1", &Distortion::s1},
    {"s2", &Distortion::s2}, {"skew", &Distortion::skew},   {"omega", &Distortion::omega},
    {"k5", &Distortion::k5}, {"k6", &Distortion::k6},       {"s3", &Distortion::s3},
    {"s4", &Distortion::s4}, {"alpha", &Distortion::alpha}, {"beta", &Distortion::beta},
    {"a1", &Distortion::a1}, {"a2", &Distortion::a2},       {"a3", &Distortion::a3},
};
inline constexpr std::size_t kBrownTerms = 5;

/// The terms that a lens of this model can have.
constexpr std::span<const LensTerm> terms_of(LensModel model) {
  return model == LensModel::brown ? std::span(kLensTerms).first(kBrownTerms) : std::span<const LensTerm>(kLensTerms);
}

inline constexpr Named<LensModel> kLensModelNames[] = {
    {"opencv", LensModel::brown},
    {"perspective", LensModel::perspective},
    {"equidistant", LensModel::equidistant},
    {"equisolid", LensModel::equisolid},
    {"fov", LensModel::fov},
    {"inverse_radial", LensModel::inverse_radial},
    {"division", LensModel::division},
    {"unified", LensModel::unified},
    {"fisheye_polynomial", LensModel::fisheye_polynomial},
    {"fisheye_624", LensModel::fisheye_624},
    {"spherical", LensModel::spherical},
    {"spherical_up", LensModel::spherical_up},
    {"spherical_down", LensModel::spherical_down},
};

}  // namespace gpvc
