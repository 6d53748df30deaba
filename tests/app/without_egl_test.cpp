// The program where EGL finds no device: everything but OpenGL works, with the same bytes.
#include <cstdlib>

#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;

test::Outcome run_without_egl(const std::vector<std::string>& words) {
  return run(words, [] { setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent", 1); });
}

class WithoutEgl : public App {
 protected:
  std::vector<std::string> command(const std::string& name, const fs::path& out,
                                   const std::vector<std::string>& more) const {
    auto words = texture(out, more);
    words[0] = name;
    return words;
  }
  /// Expects the same files from both, but for what describes the run.
  void expect_same(const std::string& name, const std::vector<std::string>& more) const {
    const fs::path with = folder_.path() / "with", without = folder_.path() / "without";
    const test::Outcome usual = run(command(name, with, more)), outcome = run_without_egl(command(name, without, more));
    ASSERT_EQ(usual.exit_code, 0) << usual.err;
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    auto expected = files_of(with), found = files_of(without);
    expected.erase("run.json");
    found.erase("run.json");
    ASSERT_EQ(expected.size(), found.size());
    for (const auto& [file, bytes] : expected) EXPECT_TRUE(found[file] == bytes) << file;
    fs::remove_all(with);
    fs::remove_all(without);
  }
};

TEST_F(WithoutEgl, TexturesAreTheSame) {
  expect_same("texture", {});
  expect_same("texture", {"--visibility", "none"});
  expect_same("texture", {"--visibility", "ray:dense:0.01", "--texture", "png"});
}

TEST_F(WithoutEgl, ClassesAreTheSame) {
  expect_same("visibility", {"--ivm"});
  expect_same("visibility", {"--visibility", "gpvc:ves", "--no-subpixel"});
}

TEST_F(WithoutEgl, ModelsAreEvaluatedAndCompared) {
  ASSERT_EQ(run_without_egl(texture(out_, {"--hold-out", "2"})).exit_code, 0);
  const test::Outcome scored =
      run_without_egl({"evaluate", (out_ / "model.obj").string(), (scene_ / "colmap").string()});
  EXPECT_EQ(scored.exit_code, 0) << scored.err;
  EXPECT_TRUE(contains(scored.out, "mean"));
  const test::Outcome compared = run_without_egl(command("compare", folder_.path() / "compared",
                                                         {"--modes", "none,ray:dense:0.01,gpvc", "--hold-out", "2",
                                                          "--oracle-views", "1", "--crops", "1", "--reduction", "1"}));
  EXPECT_EQ(compared.exit_code, 0) << compared.err;
}

TEST_F(WithoutEgl, WhatNeedsOpenGlSaysSo) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--drawing", "opengl"}, "drawing with OpenGL"},
      {{"--classifier", "gpu"}, "classifying in shaders"},
      {{"--visibility", "shadow-map:spc:0.001"}, "shadow-map:spc:0.001"},
      {{"--coverage-correction", "paper"}, "coverage correction"},
      {{"--device", "0"}, "device"}};
  for (const auto& [words, where] : cases) {
    expect_one_sentence(run_without_egl(command("visibility", out_, words)), where, "no EGL device");
    EXPECT_FALSE(fs::exists(out_));
  }
  EXPECT_EQ(run_without_egl({"texture", "--device", "list"}).exit_code, 1);
}

}  // namespace
}  // namespace gpvc
