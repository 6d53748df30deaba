// A city whose jobs are made once, for tests that look at them.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>

#include "app/tiles/done.h"
#include "app/tiles/make_job.h"
#include "app/tiles/units.h"
#include "tests/app/photographed_city.h"

namespace gpvc::tiles {

class TilesJob : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    city_ = new test::City(4000, 240, 6);
    jobs_ = new std::map<std::size_t, std::unique_ptr<test::TemporaryFolder>>();
  }
  static void TearDownTestSuite() {
    delete jobs_;
    delete city_;
  }
  checks::Input input() const { return {city_->scene, city_->mesh, city_->views}; }
  static JobSettings settings(std::size_t faces_per_tile) {
    JobSettings settings;
    settings.tiles.faces_per_tile = faces_per_tile;
    settings.views_per_unit = 2;
    settings.texture.output.texture = io::ImageFormat::png;
    return settings;
  }
  // A job that is done, made once.
  JobFolder job(std::size_t faces_per_tile) {
    std::unique_ptr<test::TemporaryFolder>& folder = (*jobs_)[faces_per_tile];
    if (folder) return JobFolder(folder->path());
    folder = std::make_unique<test::TemporaryFolder>();
    const JobFolder made(folder->path());
    make_job(made, input(), settings(faces_per_tile), "test", observer_);
    UnitRunner runner(made, {}, observer_);
    for (const Unit& unit : runner.units()) EXPECT_EQ(runner.run(unit), UnitResult::done) << unit.name;
    return made;
  }
  static double figure(const JobFolder& folder, const char* name) {
    return read_done(folder.done_file(kFinishUnit)).value().figures[name].get<double>();
  }

  static inline test::City* city_ = nullptr;
  static inline std::map<std::size_t, std::unique_ptr<test::TemporaryFolder>>* jobs_ = nullptr;
  results::Observer observer_;
};

}  // namespace gpvc::tiles
