#include <gtest/gtest.h>

#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

VisibilityOptions parsed(std::string_view mode) {
  VisibilityOptions options;
  set_visibility_mode(mode, options);
  return options;
}

std::string complaint(std::string_view mode) {
  VisibilityOptions options;
  options.epsilon = 42;
  try {
    set_visibility_mode(mode, options);
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(options.method, Method::gpvc) << "a refused mode changes nothing";
    EXPECT_EQ(options.epsilon, 42);
    EXPECT_EQ(options.projection, Projection::apc);
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
    EXPECT_EQ(visibility_mode_name(parsed(name)), name);
}

TEST(VisibilityMode, SetsWhatItNamesAndNothingElse) {
  EXPECT_EQ(parsed("gpvc:ves").sampling, Sampling::ves);
  EXPECT_EQ(parsed("ray:sparse:2").rays, Rays::sparse);
  EXPECT_EQ(parsed("ray:sparse:2").epsilon, 2);
  EXPECT_EQ(parsed("shadow-map:spc:0.5").projection, Projection::spc);
  EXPECT_EQ(parsed("shadow-map:apc:0.5").projection, Projection::apc);
  EXPECT_EQ(parsed("none").method, Method::none);
  VisibilityOptions options;
  options.projection = Projection::spc;
  options.sampling = Sampling::dense;
  options.subpixel = false;
  set_visibility_mode("ray:dense:1", options);
  EXPECT_EQ(options.projection, Projection::spc);
  EXPECT_EQ(options.sampling, Sampling::dense);
  EXPECT_FALSE(options.subpixel);
}

TEST(VisibilityMode, EpsilonIsNamedAsShortAsReadsBackExactly) {
  VisibilityOptions options = parsed("ray:dense:1");
  options.epsilon = 0.1 / 1024;
  const std::string name = visibility_mode_name(options);
  EXPECT_EQ(parsed(name).epsilon, 0.1 / 1024) << name;
  EXPECT_EQ(visibility_mode_name(parsed("ray:dense:0.00010000")), "ray:dense:1e-04");
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
