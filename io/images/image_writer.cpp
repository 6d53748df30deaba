// Pages as files.
#include <algorithm>
#include <stdexcept>

#include "io/images/codec.h"
#include "io/images/image_file.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

void write_jpeg(OutputFile& out, const fs::path& file, const Image& image, int quality, const ColorProfile& profile) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::UINT8);
  spec["Compression"] = "jpeg:" + std::to_string(std::clamp(quality, 1, 100));
  spec["jpeg:subsampling"] = "4:4:4";
  if (!profile.empty())
    spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(profile.size())),
                   profile.data());
  OIIO::Filesystem::IOVecOutput proxy;  // and from there to `out`, so that a full disk is noticed
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("jpeg");
  if (!output) throw OutputError(file, "cannot be encoded: " + one_line(OIIO::geterror(), file));
  output->threads(1);
  const bool good = output->set_ioproxy(&proxy) && output->open(file.string(), spec) &&
                    output->write_image(OIIO::TypeDesc::UINT8, image.pixels.data());
  const bool closed = output->close();
  if (!good || !closed) throw OutputError(file, "cannot be encoded: " + one_line(output->geterror(), file));
  out.write(proxy.buffer().data(), proxy.size());
}

}  // namespace

void write_image(const fs::path& file, const Image& image, ImageFormat format, int quality,
                 const ColorProfile& profile) {
  if (image.width < 1 || image.height < 1 || image.channels < 1 || image.channels > 4 ||
      image.pixels.size() != static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                                 static_cast<std::size_t>(image.channels))
    throw std::invalid_argument("write_image: the pixels do not fit the size");
  OutputFile out(file);
  if (format == ImageFormat::png)
    write_png(out, image, profile);
  else
    write_jpeg(out, file, image, quality, profile);
  out.commit();
}

}  // namespace gpvc::io
