// What the units of a job trust: photos, results and files that others have changed, replaced or left.
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "io/images.h"
#include "io/work_store.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;
using Json = nlohmann::json;

class JobTrust : public App {
 protected:
  // A job of this test's own photos, in one tile if nothing else is said.
  void make_job(const fs::path& job,
                const std::vector<std::string>& options = {"--unit-views", "2", "--no-levels"}) const {
    std::vector<std::string> words = texture(job, options);
    words[0] = "tiles";
    ASSERT_EQ(run(words).exit_code, 0);
  }
  // A complete job in four tiles, of photos that stay as they are.
  void take_job() const {
    ASSERT_TRUE(fs::exists(fs::path(GPVC_APP_JOB) / "result" / "tileset.json"))
        << "ctest makes the job: app_scene.units";
    fs::create_directories(out_.parent_path());
    fs::copy(GPVC_APP_JOB, out_, fs::copy_options::recursive);
  }
  // As if the units had not run.
  void forget(const std::vector<std::string>& names) const {
    for (const std::string& name : names) ASSERT_TRUE(fs::remove(out_ / "units" / name / "done.json")) << name;
  }
  Outcome unit(const std::vector<std::string>& names) const {
    std::vector<std::string> words{"unit", out_.string()};
    words.insert(words.end(), names.begin(), names.end());
    return run(words);
  }
  // The names of the units whose stage is one of some, or is not.
  std::vector<std::string> units(const std::set<std::string>& stages, bool of_them) const {
    std::vector<std::string> names;
    const Json plan = Json::parse(read_file(out_ / "plan.json"));
    for (const Json& each : plan["units"])
      if (stages.contains(each["stage"].get<std::string>()) == of_them) names.push_back(each["name"]);
    return names;
  }
  fs::path photo(const std::string& name) const {
    for (const auto& entry : fs::recursive_directory_iterator(scene_))
      if (entry.path().filename() == name) return entry.path();
    ADD_FAILURE() << "no photo";
    return {};
  }
  // Other bytes of the same size and time of modification, as copies that keep times bring.
  static void replace_photo(const fs::path& file) {
    struct stat before {};
    ASSERT_EQ(stat(file.c_str(), &before), 0);
    Image image = io::read_image(file);
    for (std::uint8_t& value : image.pixels) value = static_cast<std::uint8_t>(255 - value);
    io::write_image(file, image, io::ImageFormat::jpg, 60);
    ASSERT_LE(fs::file_size(file), static_cast<std::uintmax_t>(before.st_size));
    fs::resize_file(file, static_cast<std::uintmax_t>(before.st_size));
    const timespec times[2] = {before.st_atim, before.st_mtim};
    ASSERT_EQ(utimensat(AT_FDCWD, file.c_str(), times, 0), 0);
  }
  static void flip_byte(const fs::path& file) {
    std::string bytes = read_file(file);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x20);
    std::ofstream(file, std::ios::binary) << bytes;
  }
  std::map<std::string, std::string> result(const fs::path& job) const { return files_of(job / "result"); }
};

TEST_F(JobTrust, APhotoOfTheSameSizeAndTimeIsNamedOrLookedAtAgain) {
  make_job(out_);
  ASSERT_EQ(unit(units({"see", "judge", "cost"}, true)).exit_code, 0);
  replace_photo(photo("east_001.jpg"));
  expect_one_sentence(unit(units({"see", "judge", "cost"}, false)), "east_001.jpg", "run that unit again");
  EXPECT_FALSE(fs::exists(out_ / "result"));

  ASSERT_EQ(unit({"--all"}).exit_code, 0);
  const fs::path clean = folder_.path() / "clean";
  make_job(clean);
  ASSERT_EQ(run({"unit", clean.string(), "--all"}).exit_code, 0);
  EXPECT_TRUE(result(out_) == result(clean));
  // A complete unit that reads the photo does not pass for one, either.
  replace_photo(photo("east_001.jpg"));
  expect_one_sentence(unit(units({"bake"}, true)), "east_001.jpg", "run that unit again");
}

// They see photos themselves, at a reduced size.
TEST_F(JobTrust, CoarserLevelsLookAgainAtAPhotoThatHasChanged) {
  const std::vector<std::string> levels{"--tile-faces", "200"};
  make_job(out_, levels);
  ASSERT_EQ(unit({"--all"}).exit_code, 0);
  const auto before = result(out_);
  replace_photo(photo("east_001.jpg"));
  ASSERT_EQ(unit({"--all"}).exit_code, 0);
  const fs::path clean = folder_.path() / "clean";
  make_job(clean, levels);
  ASSERT_EQ(run({"unit", clean.string(), "--all"}).exit_code, 0);
  ASSERT_TRUE(fs::exists(clean / "result" / "tiles" / "1_0.glb"));
  EXPECT_TRUE(result(out_) == result(clean));
  EXPECT_FALSE(result(out_) == before);
}

TEST_F(JobTrust, APhotoWithAnotherTimeAloneIsTheSame) {
  make_job(out_);
  ASSERT_EQ(unit(units({"see"}, true)).exit_code, 0);
  fs::last_write_time(photo("east_001.jpg"), fs::file_time_type::clock::now());
  const std::string all = std::to_string(units({"see"}, true).size());
  const Outcome again = unit(units({"see"}, true));
  EXPECT_TRUE(contains(again.err, all + " of " + all + " units were complete")) << again.err;
  EXPECT_EQ(unit({"--all"}).exit_code, 0);
}

TEST_F(JobTrust, AMaskThatChangesCounts) {
  Image mask = io::read_image(photo("east_001.jpg"));
  std::ranges::fill(mask.pixels, std::uint8_t{255});
  std::fill_n(mask.at(0, 0), 3, std::uint8_t{0});
  const fs::path file = photo("east_001.jpg").string() + ".mask.png";
  io::write_image(file, mask, io::ImageFormat::png, 0);
  make_job(out_);
  ASSERT_EQ(unit(units({"see", "judge", "cost", "choose"}, true)).exit_code, 0);
  std::fill_n(mask.at(0, 5), 3, std::uint8_t{0});
  io::write_image(file, mask, io::ImageFormat::png, 0);
  expect_one_sentence(unit(units({"see", "judge", "cost", "choose"}, false)), "mask.png", "run that unit again");
}

TEST_F(JobTrust, FilesThatOthersChangedAreNamedAndMadeAgain) {
  take_job();
  const auto before = result(out_);
  for (const char* name :
       {"result/tiles/0_1.glb", "result/obj/2/model.obj", "result/obj/3/model_0.jpg", "result/tileset.json",
        "units/see-0-1/tile-2", "units/judge/photos", "units/cost-0-2/costs", "units/choose-0-2-1/labels",
        "units/expose-3/relations", "units/level/exposure", "units/level/alignment"}) {
    flip_byte(out_ / name);
    const Outcome again = unit({"--all"});
    EXPECT_EQ(again.exit_code, 0);
    EXPECT_TRUE(contains(again.err, std::string(name) + " is not what unit")) << again.err;
    EXPECT_TRUE(contains(again.err, "25 of 26 units were complete")) << again.err;
    EXPECT_TRUE(result(out_) == before) << name;
  }
}

// Changes a part, and makes the hash that it ends with right again.
void change_part(const fs::path& file) {
  const std::string bytes = read_file(file);
  io::WorkKey key;
  std::memcpy(&key, bytes.data() + 8, sizeof key);
  std::string body = bytes.substr(8 + sizeof key, bytes.size() - 8 - 2 * sizeof key);
  body[body.size() / 2] = static_cast<char>(body[body.size() / 2] ^ 0x01);
  io::WorkStore(file.parent_path()).keep(file.filename(), key, [&](io::WorkStore::Writer& out) {
    out.write(body.data(), body.size());
  });
}

TEST_F(JobTrust, PartsWithOtherValuesAreNotReadThoughTheirHashIsRight) {
  take_job();
  const auto before = result(out_);
  const std::string part = "units/cost-0-2/costs";
  change_part(out_ / part);
  forget({"choose-0-1-2"});
  // By the unit that reads it, which another has to be run for.
  expect_one_sentence(unit({"choose-0-1-2"}), part, "is missing or damaged; run unit cost-0-2 again");
  const Outcome again = unit({"--all"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_TRUE(contains(again.err, part + " is not what unit cost-0-2 made; the unit is run again")) << again.err;
  EXPECT_TRUE(result(out_) == before);

  for (const char* name : {"mesh/tile-1", "mesh/scene"}) {
    change_part(out_ / name);
    forget({"cost-0-1"});
    expect_one_sentence(unit({"cost-0-1"}), name, "is missing or damaged");
    fs::copy_file(fs::path(GPVC_APP_JOB) / name, out_ / name, fs::copy_options::overwrite_existing);
    ASSERT_EQ(unit({"cost-0-1"}).exit_code, 0);
  }
}

TEST_F(JobTrust, DoneFilesOfOtherTypesCountAsNone) {
  take_job();
  const auto before = result(out_);
  const fs::path done = out_ / "units" / "level" / "done.json";
  const std::string good = read_file(done), key = Json::parse(good)["key"].get<std::string>();
  std::vector<std::string> bad{"", "[]", R"({"key":5,"outputs":[],"figures":{}})",
                               R"({"key":null,"outputs":[],"figures":{}})", R"({"key":")" + key + R"(","outputs":[]})"};
  const std::string hash = R"("hash":"0123456789abcdef0123456789abcdef")";
  for (const std::string& outputs :
       {std::string("5"), std::string("[5]"), std::string(R"([{"file":"x","bytes":1}])"),
        R"([{"file":"x",)" + hash + "}]", R"([{"file":"x","bytes":"1",)" + hash + "}]",
        R"([{"file":5,"bytes":1,)" + hash + "}]", R"([{"file":"x","bytes":-1,)" + hash + "}]",
        R"([{"file":"../x","bytes":1,)" + hash + "}]", std::string(R"([{"file":"x","bytes":1,"hash":1}])")})
    bad.push_back(R"({"key":")" + key + R"(","outputs":)" + outputs + R"(,"figures":{}})");
  bad.push_back(R"({"key":")" + key + R"(","outputs":[],"figures":{"energy":"1"}})");
  for (const std::string& text : bad) {
    std::ofstream(done, std::ios::binary) << text;
    const Outcome again = unit({"level"});
    EXPECT_EQ(again.exit_code, 0) << text << again.err;
    EXPECT_FALSE(contains(again.err, "exception")) << again.err;
    EXPECT_TRUE(read_file(done).starts_with("{\n \"key\": \"" + key)) << text;
  }
  EXPECT_EQ(unit({"--all"}).exit_code, 0);
  EXPECT_TRUE(result(out_) == before);
  std::ofstream(out_ / "mesh" / "done.json") << R"({"key":5})";
  expect_one_sentence(unit({"--all"}), out_.string(), "is no job of units");
}

TEST_F(JobTrust, OptionsInJobJsonAreThoseOfTheJob) {
  take_job();
  const std::string good = read_file(out_ / "job.json");
  Json json = Json::parse(good);
  json["settings"]["quality"] = 50;
  std::ofstream(out_ / "job.json") << json;
  expect_one_sentence(unit({"see-0-0"}), "job.json", "quality");
  json["settings"].erase("padding");
  std::ofstream(out_ / "job.json") << json;
  expect_one_sentence(unit({"--all"}), "job.json", "padding");
  expect_one_sentence(run({"plan", out_.string()}), "job.json", "padding");
  json.erase("settings");
  std::ofstream(out_ / "job.json") << json;
  expect_one_sentence(unit({"--all"}), "job.json", "settings");
  std::ofstream(out_ / "job.json") << good;
  EXPECT_EQ(unit({"see-0-0"}).exit_code, 0);
}

TEST_F(JobTrust, UnitsFollowNoLinkOutOfTheJob) {
  const fs::path mine = folder_.path() / "mine";
  for (const char* name : {"result", "result/tiles", "result/obj", "result/obj/0", "units", "units/see-0-0"}) {
    take_job();
    fs::create_directories(mine);
    std::ofstream(mine / "model.obj") << "precious";
    fs::remove_all(out_ / name);
    fs::create_directory_symlink(mine, out_ / name);
    expect_one_sentence(unit({"--all"}), (out_ / name).string(), "is a symbolic link");
    EXPECT_EQ(read_file(mine / "model.obj"), "precious") << name;
    EXPECT_EQ(files_of(mine).size(), 1u) << name;
    fs::remove_all(out_);
    fs::remove_all(mine);
  }
}

TEST_F(JobTrust, FilesOfKilledUnitsAreRemovedAndThoseOfRunningOnesAreNot) {
  take_job();
  forget({"judge", "see-0-0", "bake-0-1"});
  const std::vector<fs::path> left{
      out_ / "units" / "judge" / "done.json.part-1-2", out_ / "units" / "see-0-0" / "views.part-1-2",
      out_ / "result" / "obj" / "1" / "offset.txt.part-1-2", out_ / "result" / "tiles" / "0_1.glb.part-1-2"};
  for (const fs::path& file : left) std::ofstream(file) << "half";
  const int lock = open((out_ / "units" / "see-0-0" / ".gpvc-lock").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(flock(lock, LOCK_EX), 0);
  expect_one_sentence(unit({"see-0-0"}), "see-0-0", "another run");
  EXPECT_TRUE(fs::exists(left[1]));
  close(lock);
  ASSERT_EQ(unit({"--all"}).exit_code, 0);
  for (const fs::path& file : left) EXPECT_FALSE(fs::exists(file)) << file;
}

}  // namespace
}  // namespace gpvc
