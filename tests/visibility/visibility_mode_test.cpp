#include <gtest/gtest.h>

#include "visibility/method.h"

namespace gpvc::visibility {
namespace {

std::string complaint(std::string_view mode) {
  try {
    parse_visibility_mode(mode);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

std::string in_quotes(std::string_view text) {
  std::string result(1, '\'');
  result.append(text).push_back('\'');
  return result;
}

TEST(VisibilityMode, EveryNameReadsBack) {
  for (const char* name : {"gpvc", "gpvc:ves", "gpvc:dense", "shadow-map:spc:1e-05", "shadow-map:apc:0.001",
                           "ray:sparse:0.1", "ray:dense:1e-13", "none"})
    EXPECT_EQ(visibility_mode_name(parse_visibility_mode(name)), name);
}

TEST(VisibilityMode, SetsWhatItNames) {
  EXPECT_EQ(std::get<Gpvc>(parse_visibility_mode("gpvc:ves")).sampling, Sampling::ves);
  EXPECT_EQ(std::get<RayTracing>(parse_visibility_mode("ray:sparse:2")).sampling, RaySampling::sparse);
  EXPECT_EQ(std::get<RayTracing>(parse_visibility_mode("ray:sparse:2")).epsilon, 2);
  EXPECT_EQ(std::get<ShadowMap>(parse_visibility_mode("shadow-map:spc:0.5")).projection, Projection::spc);
  EXPECT_EQ(std::get<ShadowMap>(parse_visibility_mode("shadow-map:apc:0.5")).projection, Projection::apc);
  EXPECT_TRUE(std::holds_alternative<NoTest>(parse_visibility_mode("none")));
}

TEST(VisibilityMode, PaperGpvcHasTheNameOfItsSampling) {
  EXPECT_EQ(visibility_mode_name(PaperGpvc{.sampling = Sampling::ves}), "gpvc:ves");
}

TEST(VisibilityMode, EpsilonIsNamedAsShortAsReadsBackExactly) {
  const std::string name = visibility_mode_name(RayTracing{RaySampling::dense, 0.1 / 1024});
  EXPECT_EQ(std::get<RayTracing>(parse_visibility_mode(name)).epsilon, 0.1 / 1024) << name;
  EXPECT_EQ(visibility_mode_name(parse_visibility_mode("ray:dense:0.00010000")), "ray:dense:1e-04");
}

TEST(VisibilityMode, RefusesWithOneSentenceThatQuotesTheMode) {
  EXPECT_EQ(complaint("shadow-map:spc"),
            "'shadow-map:spc' is no visibility mode: expected shadow-map:apc:EPS or shadow-map:spc:EPS");
  EXPECT_EQ(complaint("ray:thick:1"), "'ray:thick:1' is no visibility mode: 'thick' is neither sparse nor dense");
  for (const char* epsilon : {"0", "-1", "nan", "inf", "1e999", "0x1p3", "1,5", " 1", "1 ", "", "1m", "-0"}) {
    const std::string mode = std::string("ray:dense:") + epsilon;
    EXPECT_EQ(complaint(mode), in_quotes(mode) + " is no visibility mode: its bias " + in_quotes(epsilon) +
                                   " is not a number above 0, like 0.001 or 1e-5");
  }
  for (const char* mode : {"", ":", "GPVC", "gpvc:", "gpvc:hivers", "none:1", "shadow-map", "shadow-map:spc:1:2",
                           "shadow-map:SPC:1", "ray::1", "rays:dense:1"})
    EXPECT_TRUE(complaint(mode).starts_with(in_quotes(mode) + " is no visibility mode: ")) << mode;
}

}  // namespace
}  // namespace gpvc::visibility
