#include "io/files/zip_file.h"

#include <gtest/gtest.h>

#include <random>

#include "io/error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/zip_archive.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;

const std::filesystem::path kFile = "block.xmlz";

TEST(ZipFile, ReadsMembers) {
  const std::string long_text = "0 " + std::string(5000, 'x') + " 1";
  const std::string bytes = test::zipped({{"a.xml", "<a/>"}, {"folder\\b.txt", long_text}, {"empty", ""}});
  ASSERT_TRUE(is_zip(bytes));
  const ZipFile archive(kFile, bytes);
  EXPECT_EQ(archive.members().size(), 3);
  EXPECT_TRUE(archive.has("a.xml"));
  EXPECT_FALSE(archive.has("b.xml"));
  EXPECT_EQ(archive.read("a.xml"), "<a/>");
  EXPECT_EQ(archive.read("folder/b.txt"), long_text);
  EXPECT_EQ(archive.read("folder/b.txt", 4), "0 xx");
  EXPECT_EQ(archive.read("empty"), "");
  EXPECT_EQ(input_error([&] { archive.read("c"); }), "block.xmlz: 'c': is not in the archive");
}

// A member of a GiB in a MB, of which nothing is unpacked: a packed zero takes a thousandth of a byte.
TEST(ZipFile, RefusesBombs) {
  const std::string most(ZipFile::kAlwaysUnpacked, '\0');
  const std::string bytes = test::zipped({{"more", most + '\0'}, {"most", most}});
  const ZipFile archive(kFile, bytes);
  EXPECT_EQ(archive.read("most"), most);
  EXPECT_TRUE(contains(input_error([&] { archive.read("more"); }), "'more': claims to unpack to 1048577 bytes from "));
}

// The packed size may be as false as the other.
TEST(ZipFile, RefusesSizesBeyondItsOwn) {
  std::string bytes = test::zipped({{"a.txt", "some text"}});
  const std::size_t entry = bytes.find("PK\1\2");
  ASSERT_NE(entry, std::string::npos);
  constexpr std::size_t kPacked = 20, kUnpacked = 24;  // 4 bytes each
  for (const std::size_t at : {kPacked, kUnpacked}) bytes.replace(entry + at, 4, "\x01\x02\x03\xF0", 4);
  EXPECT_TRUE(contains(input_error([&] { ZipFile(kFile, bytes).read("a.txt"); }),
                       "'a.txt': claims to unpack to 4026728961 bytes from 1"));
}

TEST(ZipFile, RefusesDamage) {
  std::string text;
  std::mt19937 random(3);
  for (int i = 0; i < 400; ++i) text += std::to_string(random()) + " ";
  const std::string good = test::zipped({{"a.txt", text}});
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_THROW(ZipFile(kFile, std::string_view(good).substr(0, size)).read("a.txt"), InputError) << size;
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(random());
    try {
      // What is read is what was packed: members carry a checksum.
      ASSERT_EQ(ZipFile(kFile, bytes).read("a.txt"), text) << at;
    } catch (const InputError& error) {
      ASSERT_TRUE(contains(error.what(), "block.xmlz")) << error.what();
    }
  }
}

}  // namespace
}  // namespace gpvc::io
