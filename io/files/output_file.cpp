// A file that appears under its name only when complete.
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "io/file_bytes.h"
#include "io/output_file.h"

namespace gpvc::io {
namespace {

constexpr const char* kSuffix = ".part-";  // and the process's number

}  // namespace

OutputFile::OutputFile(std::filesystem::path final_name) : final_name_(std::move(final_name)) {
  static std::atomic<unsigned> serial{0};
  // Exclusive, so that a temporary file of another run is never appended to or shared. A killed run may have left one
  // of the same name: in a container every run has the same process number.
  int descriptor = -1;
  do {
    temporary_ = final_name_;
    temporary_ += kSuffix + std::to_string(::getpid()) + "-" + std::to_string(serial++);
    descriptor = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor < 0 && errno == EEXIST);
  if (descriptor >= 0) file_ = ::fdopen(descriptor, "wb");
  if (file_ == nullptr) {
    const int error = errno;
    if (descriptor >= 0) ::close(descriptor);
    throw OutputError(final_name_, std::string("cannot be written: ") + std::strerror(error));
  }
  std::setvbuf(file_, nullptr, _IOFBF, std::size_t{1} << 18);
}

OutputFile::~OutputFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void OutputFile::write(const void* data, std::size_t bytes) {
  if (bytes > 0 && std::fwrite(data, 1, bytes, file_) != bytes)
    throw OutputError(final_name_, std::string("cannot be written: ") + std::strerror(errno));
}

int OutputFile::descriptor() const { return ::fileno(file_); }

void OutputFile::commit(Flush flush) {
  const auto check = [&](bool good) {
    if (!good) throw OutputError(final_name_, std::string("cannot be written: ") + std::strerror(errno));
  };
  check(std::fflush(file_) == 0);
  if (flush == Flush::to_disk) check(::fsync(::fileno(file_)) == 0 || errno == EINVAL || errno == ENOTSUP);
  check(std::fclose(std::exchange(file_, nullptr)) == 0);
  check(::rename(temporary_.c_str(), final_name_.c_str()) == 0);
  temporary_.clear();
}

void write_file(const std::filesystem::path& file, std::string_view bytes) {
  OutputFile out(file);
  out.write(bytes.data(), bytes.size());
  out.commit();
}

void copy_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  write_file(to, FileBytes(from).view());
}

void remove_unfinished(const std::filesystem::path& folder, const std::string& name) {
  std::vector<std::filesystem::path> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string found = entry.path().filename().string();
    if (found.starts_with(name) && found.find(kSuffix, name.size()) != std::string::npos) left.push_back(entry.path());
  }
  for (const std::filesystem::path& file : left) std::filesystem::remove(file);
}

}  // namespace gpvc::io
