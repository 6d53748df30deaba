// Errors as values, and the words that the command line has for what can be done about them.
#include "app/cli/cures.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <type_traits>
#include <vector>

#include "app/evaluate/truth.h"
#include "app/pipeline/edit_files.h"
#include "app/pipeline/memory.h"
#include "app/results/output_folder.h"
#include "app/tiles/job.h"
#include "io/reference_system.h"
#include "tests/support/errors.h"
#include "tests/support/temporary_folder.h"
#include "visibility/device.h"

namespace gpvc {
namespace {

using test::contains;
using test::cures_of;

template <class... Errors>
constexpr bool kHaveOneBase = (std::is_base_of_v<Error, Errors> && ...);
static_assert(kHaveOneBase<InputError, OutputError, visibility::GpuError, pipeline::MemoryError, Cancelled>);

TEST(Errors, TellWhatWasMeasuredAndWhatWouldHelp) {
  const std::optional<Error> error = test::caught([] {
    throw InputError("mesh.ply", "", "is seen by no photo", {Cure::allow_unseen}, {{"seen_share", 0.02}});
  });
  ASSERT_TRUE(error);
  EXPECT_STREQ(error->what(), "mesh.ply: is seen by no photo");
  EXPECT_EQ(error->cures(), std::vector{Cure::allow_unseen});
  EXPECT_EQ(test::measured(*error, "seen_share"), 0.02);
  EXPECT_EQ(cures_of([] { throw Cancelled(); }), std::vector<Cure>());
}

TEST(Errors, OfReferenceSystemsHaveTheSameBase) {
  std::vector<WorldPoint> points(1);
  const std::optional<Error> error = test::caught([&] { io::transform_points("EPSG:1", "EPSG:4978", points); });
  ASSERT_TRUE(error);
  EXPECT_TRUE(contains(error->what(), "'EPSG:1' is no coordinate reference system")) << error->what();
}

TEST(Errors, OfEmptyFoldersSayWhatBelongsThere) {
  const test::TemporaryFolder empty;
  EXPECT_EQ(cures_of([&] { tiles::JobFolder(empty.path()).key(); }), std::vector{Cure::make_job});
  EXPECT_EQ(cures_of([&] { evaluate::read_truth(empty.path()); }), std::vector{Cure::synthesize});
  std::ofstream(empty.path() / "model.obj") << "v 0 0 0\n";
  EXPECT_EQ(cures_of([&] { pipeline::read_edit_model(empty.path()); }), std::vector{Cure::make_editable});
}

TEST(Errors, OfALackOfSpaceTellBothFigures) {
  const test::TemporaryFolder out;
  const results::OutputFolder folder(out.path() / "out", false, "test");
  results::Observer silent;
  const std::optional<Error> error = test::caught([&] { folder.expect_space(1e18, 1e18, silent); });
  ASSERT_TRUE(error);
  EXPECT_EQ(test::measured(*error, "least_bytes"), 1e18);
  EXPECT_EQ(test::measured(*error, "free_bytes"), folder.space());
}

TEST(Cures, FollowTheSentence) {
  EXPECT_EQ(cli::with_cures("is the mesh moved?", std::array{Cure::look_at_fit}),
            "is the mesh moved? See gpvc inspect --check --picture");
  EXPECT_EQ(cli::with_cures("m.ply: is elsewhere", {}), "m.ply: is elsewhere");
  EXPECT_EQ(cli::with_cures("m.ply: is elsewhere", std::array{Cure::allow_unseen}),
            "m.ply: is elsewhere; --allow-unseen textures all the same");
  EXPECT_EQ(cli::with_cures("out: already holds a result", std::array{Cure::other_folder, Cure::replace_result}),
            "out: already holds a result; choose another folder, or give --force to replace it when the new one is "
            "complete");
}

// A unit has neither option: they were given to the command that made its job.
TEST(Cures, OfAJobSpeakOfTheCommandThatMadeIt) {
  EXPECT_EQ(cli::with_cures("photos disagree", std::array{Cure::keep_odd_views}, true),
            "photos disagree; a job made with --keep-odd-photos textures with them all the same");
  EXPECT_EQ(cli::with_cures("unit bake-0-0 takes 3 GB", std::array{Cure::smaller_tiles, Cure::more_memory}, true),
            "unit bake-0-0 takes 3 GB; make the job with fewer --tile-faces, or free some, or allow another amount by "
            "--memory SIZE");
}

}  // namespace
}  // namespace gpvc
