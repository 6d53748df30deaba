#include <exception>
#include <utility>

#include "io/raster.h"
#include "io/rasters/raster_module.h"

namespace gpvc::io {
namespace {

void refuse(const std::filesystem::path& file, const std::string& wrong) {
  if (!wrong.empty()) throw OutputError(file, wrong);
}

/// Progress from within the module, which no exception may pass.
struct Report {
  const Progress& progress;
  std::exception_ptr thrown{};
};

int report(double share, const char*, void* data) {
  Report& report = *static_cast<Report*>(data);
  try {
    if (report.progress) report.progress(static_cast<std::size_t>(100 * share), 100);
    return 1;
  } catch (...) {
    report.thrown = std::current_exception();
    return 0;
  }
}

}  // namespace

RasterWriter::RasterWriter(std::filesystem::path file, const RasterInfo& info) : file_(std::move(file)), info_(info) {
  refuse(file_, raster_module(file_).create(file_, info_, raster_));
}

RasterWriter::~RasterWriter() {
  if (raster_ != nullptr) raster_module(file_).close(raster_);
}

void RasterWriter::write(int first_row, int rows, SampleType type, const void* samples, const std::uint8_t* mask) {
  refuse(file_, raster_module(file_).write_rows(raster_, first_row, rows, type, samples, mask));
}

void RasterWriter::write_rows(int first_row, int rows, const std::uint8_t* samples, const std::uint8_t* mask) {
  write(first_row, rows, SampleType::u8, samples, mask);
}
void RasterWriter::write_rows(int first_row, int rows, const std::uint32_t* samples) {
  write(first_row, rows, SampleType::u32, samples, nullptr);
}
void RasterWriter::write_rows(int first_row, int rows, const float* samples, const std::uint8_t* mask) {
  write(first_row, rows, SampleType::f32, samples, mask);
}

void RasterWriter::finish(const Progress& progress) {
  Report told{progress};
  const std::string wrong = raster_module(file_).finish(raster_, report, &told);
  if (told.thrown) std::rethrow_exception(told.thrown);
  refuse(file_, wrong);
}

}  // namespace gpvc::io
