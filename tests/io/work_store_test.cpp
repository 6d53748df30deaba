// Results that come back as they were kept, or not at all.
#include "io/work_store.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <numeric>

#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using Numbers = std::vector<std::uint32_t>;

WorkKey key_of(std::string_view text) {
  WorkHash hash;
  hash.add(text);
  return hash.key();
}

class Kept : public testing::Test {
 protected:
  void keep(const std::string& name, const WorkKey& key, const Numbers& numbers, double value = 0.5) {
    store_.keep(name, key, [&](WorkStore::Writer& out) {
      out.add(value);
      out.add(numbers);
    });
  }
  std::optional<Numbers> read(const std::string& name, const WorkKey& key) const {
    Numbers numbers;
    const bool found = store_.read(name, key, [&](WorkStore::Reader& in) {
      EXPECT_EQ(in.get<double>(), 0.5);
      numbers = in.get<std::vector<std::uint32_t>>();
    });
    return found ? std::optional(numbers) : std::nullopt;
  }
  static Numbers many() {
    Numbers numbers(100000);
    std::iota(numbers.begin(), numbers.end(), 7u);
    return numbers;
  }

  test::TemporaryFolder folder_;
  std::filesystem::path work_ = folder_.path() / "work of mine";
  WorkStore store_{work_};
  WorkKey key_ = key_of("a");
};

TEST(WorkHash, TellsLengthsAndOrdersApart) {
  const auto key = [](std::initializer_list<std::string_view> texts) {
    WorkHash hash;
    for (const std::string_view text : texts) hash.add(text);
    return hash.key();
  };
  EXPECT_EQ(key({"ab", "c"}), key({"ab", "c"}));
  EXPECT_NE(key({"ab", "c"}), key({"a", "bc"}));
  EXPECT_NE(key({"ab", "c"}), key({"c", "ab"}));
  EXPECT_NE(key({}), key({""}));
}

TEST(WorkHash, ReadsAFilesBytes) {
  const test::TemporaryFolder folder;
  const auto of_file = [](const std::filesystem::path& file) {
    WorkHash hash;
    hash.add_file(file);
    return hash.key();
  };
  EXPECT_EQ(of_file(folder.write("a", "some bytes")), of_file(folder.write("b", "some bytes")));
  EXPECT_NE(of_file(folder.write("a", "some bytes")), of_file(folder.write("b", "Some bytes")));
  EXPECT_THROW(of_file(folder.path() / "none"), InputError);
}

TEST_F(Kept, ComesBackUnderItsNameAndKey) {
  EXPECT_FALSE(std::filesystem::exists(work_)) << "made when it is needed";
  keep("view-1", key_, many());
  EXPECT_TRUE(store_.has("view-1", key_));
  EXPECT_EQ(WorkStore(work_).has("view-1", key_), true) << "another process'";
  EXPECT_EQ(read("view-1", key_), many());
  EXPECT_EQ(read("view-2", key_), std::nullopt);
  EXPECT_EQ(read("view-1", key_of("b")), std::nullopt);
  keep("view-1", key_of("b"), {1, 2});
  EXPECT_EQ(read("view-1", key_), std::nullopt) << "replaced";
  EXPECT_EQ(read("view-1", key_of("b")), (Numbers{1, 2}));
}

TEST_F(Kept, AnyDamageIsFound) {
  keep("view", key_, {1, 2, 3});
  const std::string whole = test::read_file(work_ / "view");
  for (std::size_t length = 0; length < whole.size(); ++length) {
    std::ofstream(work_ / "view", std::ios::binary) << whole.substr(0, length);
    ASSERT_EQ(read("view", key_), std::nullopt) << length;
  }
  for (std::size_t at = 32; at < whole.size(); ++at) {  // the value in front of the list is checked by read()
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 16);
    std::ofstream(work_ / "view", std::ios::binary) << damaged;
    ASSERT_EQ(read("view", key_), std::nullopt) << at;
  }
  std::ofstream(work_ / "view", std::ios::binary) << whole + "x";
  EXPECT_EQ(read("view", key_), std::nullopt);
  std::ofstream(work_ / "view", std::ios::binary) << whole;
  EXPECT_EQ(read("view", key_), (Numbers{1, 2, 3}));
}

// Somebody changes a value and makes the file's own hash right.
TEST_F(Kept, AListTellsWhatWasKeptFromWhatWasMadeToFit) {
  const auto numbers_in = [&](const WorkStore& store, const std::string& name) {
    Numbers numbers;
    const bool found =
        store.read(name, key_, [&](WorkStore::Reader& in) { numbers = in.get<std::vector<std::uint32_t>>(); });
    return found ? std::optional(numbers) : std::nullopt;
  };
  const auto put = [&](WorkStore store, const std::string& name, const Numbers& numbers) {
    store.keep(name, key_, [&](WorkStore::Writer& out) { out.add(numbers); });
  };
  put(WorkStore(work_, "hashes.txt"), "view 1", {1, 2, 3});
  put(WorkStore(work_, "hashes.txt"), "view 2", {4});
  EXPECT_EQ(numbers_in(WorkStore(work_, "hashes.txt"), "view 1"), (Numbers{1, 2, 3}));
  put(WorkStore(work_), "view 1", {1, 2, 4});  // not entered
  EXPECT_EQ(numbers_in(WorkStore(work_), "view 1"), (Numbers{1, 2, 4}));
  EXPECT_EQ(numbers_in(WorkStore(work_, "hashes.txt"), "view 1"), std::nullopt);
  EXPECT_EQ(numbers_in(WorkStore(work_, "hashes.txt"), "view 2"), (Numbers{4}));
  put(WorkStore(work_, "hashes.txt"), "view 1", {5});
  EXPECT_EQ(numbers_in(WorkStore(work_, "hashes.txt"), "view 1"), (Numbers{5})) << "entered anew";

  const std::string list = test::read_file(work_ / "hashes.txt");
  std::ofstream(work_ / "hashes.txt") << list.substr(0, list.size() - 9);
  put(WorkStore(work_, "hashes.txt"), "view 3", {6});
  const WorkStore after(work_, "hashes.txt");
  EXPECT_EQ(numbers_in(after, "view 1"), std::nullopt) << "its line was cut off";
  EXPECT_EQ(numbers_in(after, "view 2"), (Numbers{4}));
  EXPECT_EQ(numbers_in(after, "view 3"), (Numbers{6})) << "on a line of its own";
  WorkStore(work_, "hashes.txt").clear();
  EXPECT_FALSE(std::filesystem::exists(work_));
}

TEST_F(Kept, AFullDiskEndsTheKeepingAlone) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    keep("view-1", key_, {1});
    const rlimit small{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &small);
    keep("view-2", key_, many());
    const std::optional<OutputError> failure = store_.failure();
    const bool said = failure && std::string(failure->what()).ends_with("view-2: cannot be written: File too large");
    keep("view-3", key_, {3});
    _exit(said && store_.has("view-1", key_) && !store_.has("view-3", key_) ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_TRUE(std::filesystem::exists(work_ / "view-1"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(work_), {}), 1) << "no part of a file";
}

TEST_F(Kept, IsClearedWithoutTouchingOtherFiles) {
  keep("view-1", key_, {1});
  std::ofstream(work_ / "view-2.part-77-0") << "half";
  store_.clear();
  EXPECT_FALSE(std::filesystem::exists(work_));
  keep("view-1", key_, {1});
  std::ofstream(work_ / "thesis.txt") << "of the user";
  store_.clear();
  EXPECT_EQ(test::read_file(work_ / "thesis.txt"), "of the user");
  EXPECT_FALSE(std::filesystem::exists(work_ / "view-1"));
}

}  // namespace
}  // namespace gpvc::io
