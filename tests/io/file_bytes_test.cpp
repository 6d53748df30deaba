#include "io/file_bytes.h"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::TemporaryFolder;

// Where it were mapped, looking at it afterwards would end the process.
TEST(FileBytes, HoldAFileThatIsCutMeanwhile) {
  const TemporaryFolder folder;
  const std::string text(3 << 20, 'x');
  const auto file = folder.write("photo.jpg", text);
  const FileBytes bytes(file);
  std::filesystem::resize_file(file, 0);
  EXPECT_EQ(bytes.view(), text);
}

TEST(FileBytes, AreThoseOfFilesOfAnySize) {
  const TemporaryFolder folder;
  for (const std::size_t size : {0u, 1u, 4096u, (64u << 20) - 1, 64u << 20, (64u << 20) + 1}) {
    std::string text(size, 'a');
    if (size > 0) text.back() = 'z';
    EXPECT_TRUE(FileBytes(folder.write("file", text)).view() == text) << size;
    EXPECT_TRUE(FileBytes(folder.path() / "file", FileBytes::Use::in_places).view() == text) << size;
  }
}

TEST(FileParts, AreThoseOfTheFile) {
  const test::TemporaryFolder folder;
  const FileParts parts(folder.write("file", "0123456789"));
  EXPECT_EQ(parts.size(), 10u);
  std::string to(4, ' ');
  EXPECT_EQ(parts.read(3, to), 4u);
  EXPECT_EQ(to, "3456");
  EXPECT_EQ(parts.read(8, to), 2u);
  EXPECT_EQ(to.substr(0, 2), "89");
  EXPECT_EQ(parts.read(10, to), 0u);
  EXPECT_THROW(FileParts("/nowhere"), InputError);
  EXPECT_THROW(FileParts(folder.path()), InputError);
}

TEST(ReadPieces, GivesAFileOfAnySizeOnceAndInOrder) {
  const TemporaryFolder folder;
  for (const std::size_t size : {0u, 1u, (1u << 18) - 1, 1u << 18, (1u << 18) + 1, 700'000u}) {
    std::string text(size, 'a');
    for (std::size_t i = 0; i < size; i += 1000) text[i] = static_cast<char>('a' + i / 1000 % 26);
    std::string read;
    read_pieces(folder.write("file", text), [&](std::string_view piece) { read += piece; });
    EXPECT_TRUE(read == text) << size;
  }
  EXPECT_THROW(read_pieces(folder.path(), [](std::string_view) {}), InputError);
  EXPECT_THROW(read_pieces("/nowhere", [](std::string_view) {}), InputError);
  EXPECT_THROW(
      read_pieces(folder.write("pointer", "version https://git-lfs.github.com/spec/v1\n"), [](std::string_view) {}),
      InputError);
}

TEST(FileBytes, OfFilesWithoutASizeAreRead) {
  EXPECT_FALSE(FileBytes("/proc/self/maps").view().empty());
  EXPECT_THROW(FileBytes("/proc"), InputError);
  EXPECT_THROW(FileBytes("/nowhere"), InputError);
}

}  // namespace
}  // namespace gpvc::io
