// Hashes of files that are taken again where the file may have changed.
#include "io/file_hashes.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

class Hashes : public testing::Test {
 protected:
  void write(const std::string& text) const { std::ofstream(file_, std::ios::binary) << text; }
  WorkKey hash_now() const { return FileHashes().of(file_).hash; }

  test::TemporaryFolder folder_;
  fs::path file_ = folder_.path() / "photo.jpg";
};

TEST_F(Hashes, DependOnBytesAlone) {
  write("one");
  const WorkKey one = hash_now();
  fs::last_write_time(file_, fs::file_time_type::clock::now() - std::chrono::hours(1));
  EXPECT_EQ(hash_now(), one);
  write("two");
  EXPECT_NE(hash_now(), one);
  fs::remove(file_);
  EXPECT_THROW(hash_now(), InputError);
}

TEST_F(Hashes, SameSizeAndTimeOfModificationDoNotHideAChange) {
  write("one");
  FileHashes hashes;
  const WorkKey one = hashes.of(file_).hash;
  struct stat before {};
  ASSERT_EQ(stat(file_.c_str(), &before), 0);
  write("two");
  const timespec times[2] = {before.st_atim, before.st_mtim};
  ASSERT_EQ(utimensat(AT_FDCWD, file_.c_str(), times, 0), 0);
  EXPECT_NE(hashes.of(file_).hash, one);
}

// A file that was hashed within the granularity of its times is hashed again; one that was not is not read.
TEST_F(Hashes, AreTakenAgainWhereTimesDoNotTell) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  write("one");
  FileState state = file_state(file_);
  const WorkKey other{{1, 2}};
  const auto with = [&](const FileState& known, std::int64_t hashed_ns) {
    FileHashes hashes;
    hashes.learn(file_, {known, hashed_ns, other});
    return hashes.of(file_).hash;
  };
  EXPECT_EQ(with(state, state.changed_ns + kSecond), hash_now()) << "hashed a second after the change";
  EXPECT_EQ(with(state, state.changed_ns + 10 * kSecond), other) << "long after it";
  state.inode += 1;
  EXPECT_EQ(with(state, state.changed_ns + 10 * kSecond), hash_now()) << "another file of this name";
}

TEST_F(Hashes, OfFilesThatMustNotChange) {
  write("one");
  FileHashes hashes;
  const WorkKey one = hashes.unchanged(file_).hash;
  fs::last_write_time(file_, fs::file_time_type::clock::now() - std::chrono::hours(1));
  EXPECT_EQ(hashes.unchanged(file_).hash, one) << "touched";
  write("two");
  for (int n = 0; n < 2; ++n)
    EXPECT_TRUE(test::contains(test::input_error([&] { hashes.unchanged(file_); }),
                               "photo.jpg: has changed since it was first read"));
  write("one");
  EXPECT_EQ(hashes.unchanged(file_).hash, one);
  write("two");
  EXPECT_NE(hashes.of(file_).hash, one);
  EXPECT_NE(hashes.unchanged(file_).hash, one) << "of() takes what it finds";
}

}  // namespace
}  // namespace gpvc::io
