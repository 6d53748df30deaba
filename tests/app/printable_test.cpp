#include <gtest/gtest.h>

#include <string>

#include "app/results/observer.h"

namespace gpvc::results {
namespace {

TEST(Printable, LeavesTextAsItIs) {
  for (const std::string text :
       {"", "plain text, 100 %", "two\nlines\tand a tab", "südlich/höhe 5.jpg", "写真.jpg", "\xF0\x9F\x93\xB7"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, EscapesControlCharactersAndWhatIsNoUtf8) {
  EXPECT_EQ(printable("a\x1B[31m.jpg"), "a\\x1b[31m.jpg");
  EXPECT_EQ(printable(std::string("\0\r\x7F", 3)), "\\x00\\x0d\\x7f");
  EXPECT_EQ(printable("\x9B"
                      "31m"),
            "\\x9b31m");  // a control sequence in Latin-1
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\xc2\\x9b31m");                           // the same in UTF-8
  EXPECT_EQ(printable("h\xF6he.jpg"), "h\\xf6he.jpg");  // Latin-1
  EXPECT_EQ(printable("cut \xE5\x86"), "cut \\xe5\\x86");
  EXPECT_EQ(printable("\xC0\xAF\xF8"), "\\xc0\\xaf\\xf8");
}

TEST(BytesFromText, ReadsAmountsOfMemory) {
  EXPECT_EQ(bytes_from_text("600M"), 600'000'000u);
  EXPECT_EQ(bytes_from_text("1.5 GB"), 1'500'000'000u);
  EXPECT_EQ(bytes_from_text("4GiB"), std::size_t{4} << 30);
  for (const char* wrong : {"", "M", "4X", "-1G", "0", "1e30", "4 Gigs"})
    EXPECT_EQ(bytes_from_text(wrong), std::nullopt) << wrong;
}

}  // namespace
}  // namespace gpvc::results
