#include <gtest/gtest.h>

#include <algorithm>

#include "visibility/device.h"

namespace gpvc::visibility {
namespace {

class DeviceGl : public testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
  }
};

TEST_F(DeviceGl, ListsHardwareFirstAndNumbersInOrder) {
  const std::vector<DeviceInfo> devices = list_devices();
  EXPECT_TRUE(std::is_sorted(devices.begin(), devices.end(),
                             [](const DeviceInfo& a, const DeviceInfo& b) { return a.software < b.software; }));
  for (std::size_t i = 0; i < devices.size(); ++i) EXPECT_EQ(devices[i].index, static_cast<int>(i));
}

TEST_F(DeviceGl, FindsHardwareWhereTheListBeginsWithIt) {
  const std::vector<DeviceInfo> devices = list_devices();
  const auto found = GraphicsDevice::find_hardware();
  ASSERT_EQ(found == nullptr, devices.front().software);
  if (found) {
    EXPECT_EQ(found->info().renderer, devices.front().renderer);
  }
}

TEST_F(DeviceGl, OpensEveryListedDevice) {
  for (const DeviceInfo& info : list_devices()) {
    const GraphicsDevice device(info.index);
    EXPECT_EQ(device.info().renderer, info.renderer);
    EXPECT_NE(device.info().driver, "");
  }
}

TEST_F(DeviceGl, ListingLeavesALiveDeviceUsable) {
  const GraphicsDevice first(0);
  (void)list_devices();
  EXPECT_NO_THROW(first.make_current());
  {
    const GraphicsDevice second(0);
    second.make_current();
  }
  EXPECT_NO_THROW(first.make_current());
}

TEST_F(DeviceGl, SaysWhichDevicesThereAre) {
  try {
    const GraphicsDevice device(1000);
    FAIL() << "device 1000 opened";
  } catch (const GpuError& error) {
    EXPECT_NE(std::string(error.what()).find("device 1000 does not exist"), std::string::npos);
  }
}

}  // namespace
}  // namespace gpvc::visibility
