// Results of parts of a run: their keys, and the files that keep them.
#include "io/work_store.h"

// The functions are compiled into this file, so that programs that link the library need no other one.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <utility>

#include "io/file_bytes.h"
#include "io/files/frees.h"
#include "io/output_file.h"

namespace gpvc::io {
namespace {

constexpr std::array<char, 8> kWorkMagic{'g', 'p', 'v', 'c', 'w', 'o', 'r', '1'};

// Before and after the bytes of a result.
struct Head {
  std::array<char, 8> magic = kWorkMagic;
  WorkKey key;
  bool operator==(const Head&) const = default;
};
using Tail = WorkKey;  // of the bytes between

// The file is not what was kept.
struct Damaged {};

using File = std::unique_ptr<std::FILE, Frees<std::fclose>>;

// After the head of a file, if it has one.
File open_file(const std::filesystem::path& path, Head& head) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed)) return nullptr;  // opening a pipe would wait
  File file(std::fopen(path.c_str(), "rbe"));
  const bool whole = file && std::fread(&head, sizeof head, 1, file.get()) == 1;
  return whole && head.magic == kWorkMagic ? std::move(file) : nullptr;
}

// At the first byte of the result, if it seems to be there.
File open_result(const std::filesystem::path& path, const WorkKey& key) {
  Head head;
  File file = open_file(path, head);
  return file && head.key == key ? std::move(file) : nullptr;
}

// A result, or what a killed process has left of one, which may be empty.
bool is_result(const std::filesystem::path& path) {
  Head head;
  return open_file(path, head) || path.filename().string().find(".part-") != std::string::npos;
}

class FileWriter final : public WorkStore::Writer {
 public:
  explicit FileWriter(OutputFile& file) : file_(file) {}
  void write(const void* data, std::size_t bytes) override {
    hash_.add_bytes(data, bytes);
    file_.write(data, bytes);
  }
  Tail tail() const { return hash_.key(); }

 private:
  OutputFile& file_;
  WorkHash hash_;
};

class FileReader final : public WorkStore::Reader {
 public:
  FileReader(std::FILE* file, std::size_t bytes) : file_(file), left_(bytes) {}
  void read(void* data, std::size_t bytes) override {
    if (bytes > left_ || (bytes > 0 && std::fread(data, 1, bytes, file_) != bytes)) throw Damaged{};
    left_ -= bytes;
    hash_.add_bytes(data, bytes);
  }
  std::size_t left() const override { return left_; }
  // The hash of all that was kept, if all has been read and is that.
  std::optional<Tail> whole() {
    Tail tail;
    const bool whole = left_ == 0 && std::fread(&tail, sizeof tail, 1, file_) == 1 && tail == hash_.key();
    return whole ? std::optional(tail) : std::nullopt;
  }

 private:
  std::FILE* file_;
  std::size_t left_;
  WorkHash hash_;
};

}  // namespace

// --- keys

struct WorkHash::State {
  XXH3_state_t hash;
};

WorkHash::WorkHash() : state_(std::make_unique<State>()) { XXH3_128bits_reset(&state_->hash); }
WorkHash::~WorkHash() = default;

void WorkHash::add_bytes(const void* data, std::size_t bytes) {
  if (bytes > 0) XXH3_128bits_update(&state_->hash, data, bytes);
}

void WorkHash::add_file(const std::filesystem::path& file) {
  std::uint64_t bytes = 0;
  read_pieces(file, [&](std::string_view piece) {
    add_bytes(piece.data(), piece.size());
    bytes += piece.size();
  });
  add(bytes);  // the next file's bytes are not this one's
}

WorkKey WorkHash::key() const {
  const XXH128_hash_t hash = XXH3_128bits_digest(&state_->hash);
  return {{hash.low64, hash.high64}};
}

// --- results

struct WorkStore::State {
  State(std::filesystem::path where, std::string list_name) : folder(std::move(where)), list(std::move(list_name)) {
    if (!list.empty()) read_list();
  }
  std::filesystem::path folder;
  std::string list;  ///< of lines of two numbers and a name, the last of a name counts; empty: none
  std::map<std::string, Tail> listed{};
  bool cut_off = false;  ///< the list ends within a line, as a killed process leaves it, which costs that result
  std::atomic<bool> failed = false;
  std::optional<OutputError> reason{};
  mutable std::mutex mutex{};

  void read_list() {
    std::ifstream in(folder / list);
    for (std::string line; std::getline(in, line);) {
      cut_off = in.eof();
      std::istringstream words(line);
      Tail tail;
      std::string name;
      if (!cut_off && words >> tail.bits[0] >> tail.bits[1] && words.get() == ' ' && std::getline(words, name))
        listed[name] = tail;
    }
  }
  void enter(const std::string& name, const Tail& tail) {
    if (list.empty()) return;
    const std::lock_guard lock(mutex);
    listed[name] = tail;
    std::ofstream out(folder / list, std::ios::app);
    if (std::exchange(cut_off, false)) out << '\n';
    out << tail.bits[0] << ' ' << tail.bits[1] << ' ' << name << '\n';
    if (!out.flush()) throw OutputError(folder / list, "cannot be written");
  }
  bool is_listed(const std::string& name, const Tail& tail) const {
    if (list.empty()) return true;
    const std::lock_guard lock(mutex);
    const auto entry = listed.find(name);
    return entry != listed.end() && entry->second == tail;
  }

  void fail(const OutputError& why) {
    const std::lock_guard lock(mutex);
    if (!reason) reason = why;
    failed = true;
  }
};

WorkStore::WorkStore(std::filesystem::path folder, std::string list)
    : state_(std::make_shared<State>(std::move(folder), std::move(list))) {}

bool WorkStore::has(const std::string& name, const WorkKey& key) const {
  return open_result(state_->folder / name, key) != nullptr;
}

bool WorkStore::read(const std::string& name, const WorkKey& key, const std::function<void(Reader&)>& fill) const {
  const std::filesystem::path path = state_->folder / name;
  const File file = open_result(path, key);
  std::error_code failed;
  const std::uintmax_t bytes = file ? std::filesystem::file_size(path, failed) : 0;
  if (!file || failed || bytes < sizeof(Head) + sizeof(Tail)) return false;
  FileReader reader(file.get(), static_cast<std::size_t>(bytes) - sizeof(Head) - sizeof(Tail));
  try {
    fill(reader);
    const std::optional<Tail> tail = reader.whole();
    return tail && state_->is_listed(name, *tail);
  } catch (const Damaged&) {
    return false;
  }
}

void WorkStore::keep(const std::string& name, const WorkKey& key, const std::function<void(Writer&)>& write) {
  if (state_->failed) return;
  try {
    std::filesystem::create_directories(state_->folder);
    OutputFile file(state_->folder / name);
    const Head head{kWorkMagic, key};
    file.write(&head, sizeof head);
    FileWriter writer(file);
    write(writer);
    const Tail tail = writer.tail();
    file.write(&tail, sizeof tail);
    file.commit(OutputFile::Flush::to_system);
    state_->enter(name, tail);
  } catch (const OutputError& error) {
    state_->fail(error);
  } catch (const std::filesystem::filesystem_error& error) {
    state_->fail(OutputError(state_->folder, "cannot be written: " + error.code().message()));
  }
}

void WorkStore::clear() noexcept {
  namespace fs = std::filesystem;
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(state_->folder, failed)) {
    if (entry.is_symlink(failed)) continue;
    if (entry.is_directory(failed))
      WorkStore(entry.path(), state_->list).clear();
    else if (is_result(entry.path()) || (!state_->list.empty() && entry.path().filename() == state_->list))
      fs::remove(entry.path(), failed);
  }
  if (fs::is_directory(state_->folder, failed)) fs::remove(state_->folder, failed);  // fails unless it is empty
}

std::optional<OutputError> WorkStore::failure() const {
  const std::lock_guard lock(state_->mutex);
  return state_->reason;
}

void WorkStore::Reader::refuse() const { throw Damaged{}; }

}  // namespace gpvc::io
