#include <limits>
#include <numeric>

#include "io/npy.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;
using test::TemporaryFolder;

TEST(NpyFile, WritesTheDocumentedBytes) {
  const TemporaryFolder folder;
  const std::vector<std::int32_t> values{-1, 258};
  write_npy(folder.path() / "a.npy", values, std::vector<std::size_t>{2});
  std::string header = "{'descr': '<i4', 'fortran_order': False, 'shape': (2,), }";
  header.resize(128 - 10 - 1, ' ');
  // 10 bytes of preamble and 118 of header: the values start at 128, a multiple of 64.
  const std::string expected =
      std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header + "\n" + std::string("\xff\xff\xff\xff\x02\x01\x00\x00", 8);
  EXPECT_EQ(test::read_file(folder.path() / "a.npy"), expected);
}

template <typename T>
void expect_round_trip(const std::vector<std::size_t>& shape) {
  const TemporaryFolder folder;
  const std::size_t count = std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
  std::vector<T> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<T>(i * 37);
  if (count > 0) values.back() = std::numeric_limits<T>::max();
  write_npy(folder.path() / "a.npy", values, shape);
  EXPECT_EQ(test::read_file(folder.path() / "a.npy").size() % 64, count * sizeof(T) % 64);
  const NpyArray<T> back = read_npy<T>(folder.path() / "a.npy");
  EXPECT_EQ(back.shape, shape);
  EXPECT_EQ(back.values, values);
}

TEST(NpyFile, ReadsBackEveryTypeAndShape) {
  for (const std::vector<std::size_t>& shape : {std::vector<std::size_t>{},
                                                {1},
                                                {0},
                                                {568308},
                                                {7, 5},
                                                {0, 4},
                                                {2, 3, 4},
                                                {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}}) {
    expect_round_trip<std::uint8_t>(shape);
    expect_round_trip<std::int32_t>(shape);
    expect_round_trip<std::uint32_t>(shape);
    expect_round_trip<float>(shape);
    expect_round_trip<double>(shape);
  }
}

TEST(NpyFile, RefusesFilesCutAtEveryByte) {
  const TemporaryFolder folder;
  const std::vector<std::uint32_t> values{1, 2, 3};
  write_npy(folder.path() / "a.npy", values, std::vector<std::size_t>{3});
  const std::string good = test::read_file(folder.path() / "a.npy");
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_THROW(read_npy<std::uint32_t>(folder.write("cut.npy", good.substr(0, size))), InputError) << size;
}

TEST(NpyFile, RefusesOtherArrays) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& dict, const std::string& values) {
    const auto length = static_cast<std::uint16_t>(dict.size());
    const auto file =
        folder.write("a.npy", std::string("\x93NUMPY\x01\x00", 8) + test::bytes_of(length) + dict + values);
    return input_error([&] { read_npy<std::int32_t>(file); });
  };
  EXPECT_TRUE(
      contains(error("{'descr': '>i4', 'fortran_order': False, 'shape': (1,), }", "abcd"), "expected values of"));
  EXPECT_TRUE(contains(error("{'descr': '<i4', 'fortran_order': True, 'shape': (1,), }", "abcd"), "Fortran"));
  EXPECT_TRUE(contains(error("{'fortran_order': False, 'shape': (1,), }", "abcd"), "'descr'"));
  EXPECT_TRUE(contains(error("{'descr': '<i4', 'fortran_order': False, 'shape': (-1,), }", "abcd"), "shape"));
  EXPECT_TRUE(contains(error("{'descr': '<i4', 'fortran_order': False, 'shape': 1, }", "abcd"), "shape"));
  // 2^32 * 2^32 values: the product does not fit 64 bits.
  EXPECT_TRUE(contains(error("{'descr': '<i4', 'fortran_order': False, 'shape': (4294967296, 4294967296), }", "abcd"),
                       "the file ends"));
  EXPECT_TRUE(contains(input_error([&] { read_npy<float>(folder.write("b.npy", "PNG")); }), "b.npy"));
}

}  // namespace
}  // namespace gpvc::io
