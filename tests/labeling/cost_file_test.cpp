#include <gtest/gtest.h>

#include <filesystem>

#include "io/npy.h"
#include "labeling/labeling.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::labeling {
namespace {

namespace fs = std::filesystem;

struct CostFile : testing::Test {
  fs::path write(const std::string& bytes) const { return folder.write("table.spt", bytes); }

  const test::TemporaryFolder folder;
  const fs::path folder_ = folder.path();
};

std::string record(std::uint32_t face, std::uint16_t view, float cost) {
  return test::bytes_of(face) + test::bytes_of(view) + test::bytes_of(cost);
}

const CostTable kTable{{0, 2, 2, 3}, {1, 4, 0}, {0.5f, 0.25f, 1.0f}};

void expect_table(const CostTable& table) {
  EXPECT_EQ(table.first, kTable.first);
  EXPECT_EQ(table.views, kTable.views);
  EXPECT_EQ(table.costs, kTable.costs);
}

TEST_F(CostFile, FolderComesBackAsWritten) {
  write_costs(folder_ / "costs", kTable);
  expect_table(read_costs(folder_ / "costs"));
}

TEST_F(CostFile, FolderWithUnequalArraysIsRefused) {
  write_costs(folder_ / "costs", kTable);
  const std::size_t shape[] = {2};
  io::write_npy(folder_ / "costs" / "costs.npy", std::vector<float>{1, 2}, shape);
  EXPECT_THROW(read_costs(folder_ / "costs"), InputError);
  write_costs(folder_ / "costs", {{0, 2}, {4, 1}, {0, 0}});
  EXPECT_THROW(read_costs(folder_ / "costs"), InputError);  // views descend
  write_costs(folder_ / "costs", {{0, 1}, {4}, {-1}});
  EXPECT_THROW(read_costs(folder_ / "costs"), InputError);  // negative cost
}

TEST_F(CostFile, FolderWithVastViewNumbersIsRefused) {
  write_costs(folder_ / "costs", {{0, 1}, {65535}, {0}});
  EXPECT_NO_THROW(read_costs(folder_ / "costs"));
  for (const std::uint32_t view : {65536u, 200000000u, 0xFFFFFFFFu}) {
    write_costs(folder_ / "costs", {{0, 1, 3}, {4, 1, view}, {0, 0, 0}});
    const std::string refusal = test::input_error([&] { read_costs(folder_ / "costs"); });
    EXPECT_TRUE(test::contains(refusal, "views.npy")) << refusal;
    EXPECT_TRUE(
        test::contains(refusal, "face 1: has the view " + std::to_string(view) + "; expected numbers below 65536"))
        << refusal;
  }
}

TEST_F(CostFile, SparseTableInAnyOrder) {
  expect_table(read_costs(write("SPT 0.2 3 5 3\n" + record(2, 0, 1.0f) + record(0, 4, 0.25f) + record(0, 1, 0.5f))));
}

TEST_F(CostFile, SparseTableCutAnywhereIsRefused) {
  const std::string whole = "SPT 0.2 3 5 2\n" + record(2, 0, 1.0f) + record(0, 4, 0.25f);
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes)
    EXPECT_THROW(read_costs(write(whole.substr(0, bytes))), InputError) << bytes << " bytes";
  EXPECT_NO_THROW(read_costs(write(whole)));
}

TEST_F(CostFile, SparseTableOutOfRangeIsRefused) {
  EXPECT_THROW(read_costs(write("SPT 0.2 3 5 1\n" + record(3, 0, 1.0f))), InputError);
  EXPECT_THROW(read_costs(write("SPT 0.2 3 5 1\n" + record(0, 5, 1.0f))), InputError);
  EXPECT_THROW(read_costs(write("SPT 0.2 3 5 2\n" + record(0, 1, 1.0f) + record(0, 1, 0.5f))), InputError);
  EXPECT_THROW(read_costs(write("SPT 0.2 3 5 1\n" + record(0, 1, -1.0f))), InputError);
  // Faces without entries take no bytes, so a header can claim billions of them; no memory is allocated for those.
  EXPECT_THROW(read_costs(write("SPT 0.2 4294967294 5 1\n" + record(0, 1, 1.0f))), InputError);
  EXPECT_THROW(read_costs(folder_ / "missing.spt"), InputError);
}

}  // namespace
}  // namespace gpvc::labeling
