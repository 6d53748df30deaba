// How much memory a run may take, and how it shares it.
#include "app/pipeline/memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "app/pipeline/pipeline.h"
#include "app/results/observer.h"
#include "app/synth/city.h"
#include "app/synth/synth_scene.h"
#include "tests/support/errors.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

void put(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

TEST(AvailableMemory, IsWhatTheMachineHasWithoutGroups) {
  const test::TemporaryFolder root;
  put(root.path() / "proc/meminfo", "MemTotal:       4000 kB\nMemAvailable:       3000 kB\n");
  EXPECT_EQ(available_memory(root.path()), std::size_t{3000} * 1024);
}

TEST(AvailableMemory, IsWhatTheTightestGroupLeaves) {
  const test::TemporaryFolder root;
  put(root.path() / "proc/meminfo", "MemAvailable:       3000000 kB\n");
  put(root.path() / "proc/self/cgroup", "0::/user.slice/run.scope\n");
  const fs::path outer = root.path() / "sys/fs/cgroup/user.slice", inner = outer / "run.scope";
  put(inner / "memory.max", "max\n");
  put(inner / "memory.current", "1000\n");
  put(outer / "memory.max", "500000\n");
  put(outer / "memory.current", "200000\n");
  put(outer / "memory.stat", "anon 100000\ninactive_file 50000\n");
  EXPECT_EQ(available_memory(root.path()), 350000u) << "files that the kernel may drop are free";
  put(outer / "memory.current", "900000\n");
  EXPECT_EQ(available_memory(root.path()), 0u);
}

TEST(AvailableMemory, KnowsGroupsOfVersionOne) {
  const test::TemporaryFolder root;
  put(root.path() / "proc/meminfo", "MemAvailable:       3000000 kB\n");
  put(root.path() / "proc/self/cgroup", "5:cpu,cpuacct:/a\n4:memory:/a\n");
  put(root.path() / "sys/fs/cgroup/memory/a/memory.limit_in_bytes", "700000\n");
  put(root.path() / "sys/fs/cgroup/memory/a/memory.usage_in_bytes", "100000\n");
  EXPECT_EQ(available_memory(root.path()), 600000u);
}

TEST(ReadableBytes, HasAUnit) {
  EXPECT_EQ(results::readable_bytes(639.2e6), "640 MB");
  EXPECT_EQ(results::readable_bytes(3.24e9), "3.2 GB");
}

class MemoryPlanTest : public testing::Test {
 protected:
  MemoryPlanTest() {
    synth::FlightOptions flight;
    flight.photos = 6;
    flight.width = 2400;
    flight.height = 1600;
    flight.size_m = 50;
    mesh_ = synth::make_city({flight, 4000}).mesh;
    scene_.views = synth::synth_flight(flight);
    views_ = all_views(scene_);
  }
  MemoryPlan plan(double bytes) const {
    Settings settings;
    settings.memory_bytes = static_cast<std::size_t>(bytes);
    return plan_memory({scene_, mesh_, views_}, settings);
  }

  Mesh mesh_;
  Scene scene_;
  std::vector<ViewId> views_;
};

TEST_F(MemoryPlanTest, LimitIsSharedBetweenPagesAndPhotos) {
  const MemoryPlan lean = plan(0), rich = plan(4e9);
  EXPECT_LT(lean.limit, 1e9) << "a small scene takes little by itself";
  EXPECT_LE(rich.limit, 4e9);
  EXPECT_GT(rich.limit, 3.5e9);
  EXPECT_GT(rich.photos_while_seeing(), lean.photos_while_seeing());
  const double pages = 1e9, page = 1e8;
  for (const MemoryPlan& each : {lean, rich}) {
    const MemoryPlan::Shares shares = each.while_baking(pages, page);
    const double batch_in_need = 64e6, free_in_pages = atlas::kFinishedPart * static_cast<double>(shares.pages);
    EXPECT_LE(each.need.bake + static_cast<double>(shares.pages + shares.batch + shares.photos) -
                  std::max(batch_in_need, free_in_pages),
              std::max(each.limit, each.need.bake + page) + 1);
    EXPECT_GE(shares.batch, static_cast<std::size_t>(batch_in_need));
    EXPECT_LE(each.need.see + static_cast<double>(each.photos_while_seeing()), each.limit + 1);
    EXPECT_LE(each.peak(), each.limit);
  }
  EXPECT_EQ(rich.while_baking(pages, page).pages, std::size_t{1000000000}) << "pages come before photos";
  EXPECT_GT(rich.while_baking(pages, page).photos, 0u);
  EXPECT_EQ(lean.while_baking(pages, page).photos, 0u);
  EXPECT_LT(lean.while_baking(pages, page).pages, std::size_t{1000000000}) << "not all pages fit";
}

// What is known of the views, and judging them, comes before photos that are kept.
TEST_F(MemoryPlanTest, PhotosMakeRoomForJudging) {
  const MemoryPlan rich = plan(4e9);
  const double held = 1e9;
  const auto kept = static_cast<double>(rich.photos_while_judging(held));
  EXPECT_GT(kept, 0);
  EXPECT_LE(kept + held, rich.limit);
  EXPECT_NEAR(static_cast<double>(rich.photos_while_judging(0)) - kept, held, 2) << "rounded to bytes";
  EXPECT_EQ(rich.photos_while_judging(4e9), 0u);
}

TEST(MemoryNeed, JudgingTakesMoreWhereViewsShowLargeFaces) {
  Workload work;
  work.faces = 1e6;
  work.pairs = 20e6;
  work.pair_pixels = 20e6;
  const double small_faces = memory_need(work).judge;
  work.pair_pixels = 2000e6;
  const double large_faces = memory_need(work).judge;
  EXPECT_GT(large_faces, small_faces + 1e9) << "each is a cell by itself";
  work.pair_pixels = 20000e6;
  EXPECT_EQ(memory_need(work).judge, large_faces) << "and there are no more cells than faces";
}

double sum(const MemoryPlan::Shares& of) { return static_cast<double>(of.pages + of.batch + of.photos); }

TEST_F(MemoryPlanTest, WhatViewsSeeOfPartialFacesIsHeldWhileBaking) {
  visibility::CoverageTable coverage;
  coverage.words.resize(20'000'000);
  const MemoryPlan without = plan(4e9), with = with_coverage(without, coverage);
  EXPECT_NEAR(sum(without.while_baking(1e9, 1e8)) - sum(with.while_baking(1e9, 1e8)), 160e6, 3) << "rounded to bytes";
  EXPECT_EQ(with.limit, without.limit);
}

TEST_F(MemoryPlanTest, WhatViewsSeeOfPartialFacesRaisesALimitThatNobodySet) {
  visibility::CoverageTable coverage;
  coverage.words.resize(1'000'000);
  const MemoryPlan without = plan(0), with = with_coverage(without, coverage);
  EXPECT_DOUBLE_EQ(with.limit, without.limit + 8e6);
  EXPECT_NEAR(sum(with.while_baking(1e9, 1e8)), sum(without.while_baking(1e9, 1e8)), 3) << "rounded to bytes";
  MemoryPlan full = without;
  full.most = full.limit;
  EXPECT_EQ(with_coverage(full, coverage).limit, full.limit) << "the machine has no more";
}

TEST(MemoryNeed, EachThreadHasAnIndexOfAllFaces) {
  Workload work;
  work.faces = 20e6;
  work.views = 100;
  const MemoryNeed two = memory_need(work, 2), many = memory_need(work, 64);
  EXPECT_NEAR(many.see - two.see, 62 * 4 * 20e6, 1);
  EXPECT_NEAR(many.choose - two.choose, 62 * 4 * 20e6, 1);
  EXPECT_EQ(many.bake, two.bake);
  work.views = 3;
  EXPECT_NEAR(memory_need(work, 64).see - memory_need(work, 2).see, 4 * 20e6, 1) << "a view is averaged by one thread";
}

TEST_F(MemoryPlanTest, TooLittleIsRefusedWithWhatIsNeeded) {
  try {
    plan(10e6);
    FAIL() << "10 MB cannot be enough";
  } catch (const MemoryError& error) {
    EXPECT_TRUE(test::contains(error.what(), "10 MB may be used")) << error.what();
    EXPECT_EQ(std::ranges::count(error.cures(), Cure::smaller_photos), 1);
    EXPECT_EQ(std::ranges::count(error.cures(), Cure::more_memory), 1);
    EXPECT_GT(test::measured(error, "needed_bytes"), 1e7);
    EXPECT_EQ(test::measured(error, "allowed_bytes"), 1e7);
  }
}

// A unit is started with what its job's plan says, and finds more partial faces than the plan could know of.
TEST_F(MemoryPlanTest, WhatAPlanPromisedIsEnough) {
  visibility::CoverageTable coverage;
  coverage.words.resize(1000000);
  const Input input{scene_, mesh_, views_};
  Settings settings;
  settings.memory_bytes = std::size_t{300000000};
  const double enough = plan_baking(input, settings, {}, 3e8).need.bake;
  settings.memory_bytes = static_cast<std::size_t>(enough);
  EXPECT_THROW(plan_baking(input, settings, coverage, enough + 1e6), MemoryError) << "less than was promised";
  const MemoryPlan plan = plan_baking(input, settings, coverage, enough);
  EXPECT_GE(plan.limit, plan.need.bake);
  EXPECT_GE(plan.need.bake, enough + 8e6);
}

}  // namespace
}  // namespace gpvc::pipeline
