#include "io/files/text_scan.h"

#include <gtest/gtest.h>

namespace gpvc::io {
namespace {

TEST(Quote, LeavesNamesInAnyLanguage) {
  EXPECT_EQ(quote("südlich/höhe 5.jpg"), "'südlich/höhe 5.jpg'");
  EXPECT_EQ(quote("a\x1B[31m\x7F"), "'a?[31m?'");
  EXPECT_EQ(quote("M\xFCller \xE5\x86"), "'M?ller \?\?'") << "no UTF-8, which Python's strings refuse";
  EXPECT_EQ(quote("\xED\xA0\x80\xC0\x80\xF4\x90\x80\x80"), "'" + std::string(9, '?') + "'");
}

TEST(Quote, CutsBetweenCharacters) {
  const std::string most(40, 'x');
  EXPECT_EQ(quote(most), "'" + most + "'");
  EXPECT_EQ(quote(most + "y"), "'" + most + "...'");
  EXPECT_EQ(quote(most.substr(1) + "写真"), "'" + most.substr(1) + "...'");
  EXPECT_EQ(quote(most.substr(3) + "写真"), "'" + most.substr(3) + "写...'");
  EXPECT_EQ(quote(std::string(50, '\x80')), "'...'");  // no UTF-8
}

}  // namespace
}  // namespace gpvc::io
