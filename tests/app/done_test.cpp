// The lists of what units have made.
#include "app/tiles/done.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

#include "tests/support/temporary_folder.h"

namespace gpvc::tiles {
namespace {

namespace fs = std::filesystem;

TEST(DoneList, SaysWhatIsInTheFileNow) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "files.json";
  const auto list_of = [](std::uintmax_t bytes) {
    return Done{io::WorkKey{{1, 2}}, {UnitOutput{"a", bytes, io::WorkKey{{3, 4}}}}};
  };
  DoneList list(file);
  EXPECT_FALSE(list.read()) << "there is none";
  write_done(file, list_of(5));
  const std::shared_ptr<const Done> first = list.read();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->outputs, list_of(5).outputs);
  EXPECT_EQ(list.read(), first) << "is parsed once";
  // In its place, with the size and the time that it had.
  const auto time = fs::last_write_time(file);
  folder.write(file.filename(), test::replaced(test::read_file(file), "5", "6"));
  fs::last_write_time(file, time);
  const std::shared_ptr<const Done> second = list.read();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->outputs, list_of(6).outputs);
  EXPECT_EQ(first->outputs, list_of(5).outputs) << "who holds it goes on";
  folder.write(file.filename(), "{");
  EXPECT_FALSE(list.read()) << "is damaged";
  write_done(file, list_of(6));
  EXPECT_TRUE(list.read());
  fs::remove(file);
  EXPECT_FALSE(list.read()) << "is gone";
}

}  // namespace
}  // namespace gpvc::tiles
