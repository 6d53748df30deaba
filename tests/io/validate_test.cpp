#include "io/validate.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

using test::contains;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

struct Input {
  Scene scene;
  Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  std::vector<ViewId> views{ViewId{0}, ViewId{1}};

  Input() {
    scene.views.resize(2);
    for (View& view : scene.views) {
      view.name = "view.jpg";
      view.camera = {40, 30, 50, 50, 20, 15, {}};
    }
  }
};

std::string complaint(const std::function<void(Input&)>& change) {
  Input input;
  change(input);
  return test::input_error([&] { validate(input.scene, input.mesh, input.views); });
}

TEST(Validate, TakesWhatReadersGive) {
  const Input right;
  EXPECT_NO_THROW(validate(right.scene, right.mesh, right.views));
  EXPECT_NO_THROW(validate(right.scene, right.mesh));
  EXPECT_NO_THROW(validate_faces(Mesh{{{1e60, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}))
      << "which nothing divides by";
  EXPECT_NO_THROW(validate(Mesh{})) << "a part of a mesh may have no faces";
}

TEST(Validate, NamesTheFirstThingThatIsWrong) {
  const struct {
    std::function<void(Input&)> change;
    const char* sentence;
  } kWrong[] = {
      {[](Input& i) { i.mesh.faces.clear(); }, "the mesh: has no faces"},
      {[](Input& i) {
         i.mesh.faces.push_back({0, 3, 1});
       },
       "the mesh: face 1 names vertex 3, expected one of the 3"},
      {[](Input& i) {
         i.mesh.faces[0] = {0, 0xFFFFFFFFu, 1};
       },
       "the mesh: face 0 names vertex 4294967295"},
      {[](Input& i) { i.mesh.positions[1].y = kNan; }, "the mesh: the position of vertex 1 is (1, nan, 0)"},
      {[](Input& i) { i.mesh.positions[2].z = -kInfinity; }, "the position of vertex 2 is (0, 1, -inf)"},
      {[](Input& i) { i.mesh.positions[2].z = 2e18; }, "expected numbers of at most 1e+18"},
      {[](Input& i) { i.mesh.file_positions.resize(2); }, "has 2 positions in the file"},
      {[](Input& i) { i.mesh.source_face.resize(2); }, "has 2 source faces"},
      {[](Input& i) { i.views.clear(); }, "the scene: no view is to be used"},
      {[](Input& i) {
         i.views = {ViewId{0}, ViewId{2}};
       },
       "the scene: view 2 is to be used, expected one of the 2"},
      {[](Input& i) {
         i.views = {ViewId{1}, ViewId{0}};
       },
       "view 0 is to be used after view 1"},
      {[](Input& i) {
         i.views = {ViewId{1}, ViewId{1}};
       },
       "view 1 is to be used after view 1"},
      {[](Input& i) { i.scene.views[1].camera.width = 0; }, "view 'view.jpg': is 0 x 30 pixels large"},
      {[](Input& i) { i.scene.views[1].camera.height = 1 << 20; }, "is 40 x 1048576 pixels large"},
      {[](Input& i) { i.scene.views[1].camera.fx = 0; }, "has a focal length of 0 pixels"},
      {[](Input& i) { i.scene.views[1].camera.fy = kNan; }, "has a focal length of nan pixels"},
      {[](Input& i) { i.scene.views[0].camera.cx = kInfinity; }, "has its principal point at inf pixels"},
      {[](Input& i) { i.scene.views[0].camera.distortion.p2 = kNan; }, "has a lens with a term that is no number"},
      {[](Input& i) { i.scene.views[0].camera.distortion.motion.turn[0] = kNan; }, "a term that is no number"},
      {[](Input& i) { i.scene.views[0].pose.rotation[0] = 2; }, "has a rotation that is none"},
      {[](Input& i) { i.scene.views[0].pose.rotation[0] = -1; }, "has a rotation that is none"},
      {[](Input& i) { i.scene.views[0].pose.rotation[5] = kNan; }, "has a rotation that is none"},
      {[](Input& i) { i.scene.views[0].pose.centre.x = kNan; }, "stands at (nan, 0, 0)"},
      {[](Input& i) { i.scene.views[0].reduction = 0; }, "has photos reduced 0 times"},
  };
  for (const auto& [change, sentence] : kWrong) {
    const std::string said = complaint(change);
    EXPECT_TRUE(contains(said, sentence)) << sentence << ", got: " << said;
  }
}

TEST(Validate, OfManyFacesTheFirstIsNamed) {
  Input input;
  input.mesh.faces.assign(300000, {0, 1, 2});
  input.mesh.faces[299999] = input.mesh.faces[123456] = {0, 1, 9};
  EXPECT_TRUE(contains(test::input_error([&] { validate(input.mesh); }), "face 123456 names vertex 9"));
}

}  // namespace
}  // namespace gpvc
