#include <sys/mount.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "io/npy.h"
#include "io/output_file.h"
#include "io/scratch_file.h"
#include "io/textured_model.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::TemporaryFolder;

template <typename Call>
std::string output_error(const Call& call) {
  try {
    call();
  } catch (const OutputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no OutputError";
  return {};
}

TEST(OutputFile, AppearsUnderItsNameOnlyWhenComplete) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a file";
  {
    OutputFile out(file);
    out.write("first ");
    EXPECT_FALSE(std::filesystem::exists(file));
    out.write("second");
    out.commit();
    EXPECT_EQ(test::read_file(file), "first second");
  }
  EXPECT_EQ(folder.count(), 1);
}

TEST(OutputFile, LeavesNothingAndTheOldFileWithoutCommit) {
  const TemporaryFolder folder;
  const auto file = folder.write("a", "old");
  {
    OutputFile out(file);
    out.write("new");
  }
  EXPECT_EQ(test::read_file(file), "old");
  EXPECT_EQ(folder.count(), 1);
}

TEST(OutputFile, StepsAsideForWhatAKilledRunLeft) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a";
  const auto name_of_part = [&] {
    const OutputFile out(file);
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) return entry.path().string();
    return std::string();
  };
  // The names that the next ones would have: a run in a container has the number of the killed one, and counts from 0.
  const std::string part = name_of_part(), stem = part.substr(0, part.rfind('-') + 1);
  const int serial = std::stoi(part.substr(stem.size()));
  for (int next = serial + 1; next < serial + 4; ++next) std::ofstream(stem + std::to_string(next)) << "half";
  OutputFile out(file);
  out.write("whole");
  out.commit();
  EXPECT_EQ(test::read_file(file), "whole");
  EXPECT_EQ(folder.count(), 4);
}

TEST(OutputFile, SaysWhyAFolderCannotBeWritten) {
  const TemporaryFolder folder;
  const auto absent = folder.path() / "absent" / "a";
  EXPECT_TRUE(
      contains(output_error([&] { OutputFile out(absent); }), absent.string() + ": cannot be written: No such"));
  const auto file = folder.write("file", "x");
  EXPECT_TRUE(contains(output_error([&] { OutputFile out(file / "a"); }), "Not a directory"));
  // A folder in the place of the file.
  std::filesystem::create_directories(folder.path() / "taken" / "full");
  OutputFile out(folder.path() / "taken");
  EXPECT_TRUE(contains(output_error([&] { out.commit(); }), "cannot be written"));
}

TEST(OutputFile, SaysThatAFolderIsReadOnly) {
  const TemporaryFolder folder;
  // Root may write everywhere: be somebody else for a moment.
  const bool root = ::geteuid() == 0;
  constexpr uid_t kNobody = 65534;
  if (root && ::seteuid(kNobody) != 0) GTEST_SKIP() << "root cannot become another user here";
  if (!root) std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_read);
  EXPECT_TRUE(contains(output_error([&] { OutputFile out(folder.path() / "a"); }), "Permission denied"));
  if (root && ::seteuid(0) != 0) FAIL() << "not root again";
  if (!root) std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
}

/// A file system of 256 KiB.
class TinyDisk {
 public:
  TinyDisk() { mounted_ = ::mount("tmpfs", folder_.path().c_str(), "tmpfs", 0, "size=256k") == 0; }
  ~TinyDisk() {
    if (mounted_) ::umount2(folder_.path().c_str(), MNT_DETACH);
  }
  bool mounted() const { return mounted_; }
  const TemporaryFolder& folder() const { return folder_; }

 private:
  TemporaryFolder folder_;
  bool mounted_ = false;
};

TEST(FullDisk, StopsEveryWriterWithNothingLeft) {
  const TinyDisk disk;
  if (!disk.mounted()) GTEST_SKIP() << "no permission to mount a small file system";
  const auto folder = disk.folder().path();
  const auto full = [&](const auto& call) {
    EXPECT_TRUE(contains(output_error(call), "No space left"));
    EXPECT_EQ(disk.folder().count(), 0);
  };
  full([&] {
    OutputFile out(folder / "a");
    out.write(std::string(1 << 20, 'x'));
    out.commit();
  });
  const std::vector<std::uint32_t> values(1 << 17);
  full([&] { write_npy(folder / "a.npy", values, std::vector<std::size_t>{values.size()}); });
  Image image{600, 600, 3, {}};
  for (std::uint32_t i = 0, noise = 1; i < 3 * 600 * 600; ++i, noise = noise * 1664525u + 1013904223u)
    image.pixels.push_back(static_cast<std::uint8_t>(noise >> 24));
  full([&] {
    const std::vector<char> page(1 << 22);
    ScratchFile(folder).write(0, page.data(), page.size());
  });
  full([&] { write_image(folder / "a.png", image, ImageFormat::png, 0); });
  full([&] { write_image(folder / "a.jpg", image, ImageFormat::jpg, 100); });

  const TemporaryFolder elsewhere;
  write_image(elsewhere.path() / "page.png", image, ImageFormat::png, 0);
  Mesh mesh;
  TexturedModel model;
  model.mesh = &mesh;
  for (std::uint32_t i = 0; i < 30000; ++i) {
    mesh.positions.push_back({0.1 * i, 0.2 * i, 0.3 * i});
    model.texcoords.push_back({0.5f, 0.25f});
    mesh.faces.push_back({i, i, i});
    model.face_texcoords.push_back({i, i, i});
    model.face_page.push_back(0);
  }
  const std::vector<PageFile> pages{{elsewhere.path() / "page.png", ImageFormat::png}};
  full([&] { write_gltf(folder / "a", GltfContainer::glb, model, pages, {}); });
  EXPECT_TRUE(contains(output_error([&] { write_obj(folder / "a.obj", model, pages, {}); }), "No space left"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.obj"));
}

TEST(ScratchFile, GivesBackWhatWasWrittenAndAppearsNowhere) {
  const TemporaryFolder folder;
  {
    ScratchFile file(folder.path());
    const std::vector<int> first{1, 2, 3}, second{4, 5};
    file.write(1000, second.data(), 8);
    file.write(0, first.data(), 12);
    EXPECT_EQ(folder.count(), 0);
    std::vector<int> read(3);
    file.read(0, read.data(), 12);
    EXPECT_EQ(read, first);
    file.read(1000, read.data(), 8);
    EXPECT_EQ(read, (std::vector<int>{4, 5, 3}));
    EXPECT_NE(output_error([&] { file.read(1004, read.data(), 12); }).find(folder.path().string()), std::string::npos)
        << "nothing was written there";
  }
  EXPECT_EQ(folder.count(), 0);
}

TEST(ScratchFile, NamesTheFolderThatTakesNone) {
  const TemporaryFolder folder;
  const auto missing = folder.path() / "not there";
  EXPECT_NE(output_error([&] { ScratchFile file(missing); }).find(missing.string()), std::string::npos);
}

}  // namespace
}  // namespace gpvc::io
