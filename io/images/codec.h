// Image files through OpenImageIO: what all that reads pixels shares.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <filesystem>
#include <memory>
#include <string>

#include "io/images/image_bounds.h"

namespace gpvc::io {

/// OpenImageIO's messages span lines and repeat the file's name; ours are one sentence.
std::string one_line(std::string text, const std::filesystem::path& file);

/// Opens a file of a format that is accepted, and checks what it claims. Throws InputError.
std::unique_ptr<OIIO::ImageInput> open_image(const std::filesystem::path& file);

/// The same for a PNG or JPEG in memory, through `reader` of its bytes, which must outlive the result.
std::unique_ptr<OIIO::ImageInput> open_image(const ImageBytes& image, OIIO::Filesystem::IOMemReader& reader);

/// Decodes the first channels. Throws InputError unless the whole picture could be decoded.
void decode_samples(const ImageBytes& image, OIIO::ImageInput& input, int channels, OIIO::TypeDesc type, void* pixels);

}  // namespace gpvc::io
