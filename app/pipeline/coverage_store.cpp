#include "app/pipeline/coverage_store.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace gpvc::pipeline {
namespace {

constexpr std::uint64_t kNone = 0, kAll = ~std::uint64_t{0};

/// Boxes of up to so many bits are stored as they are.
constexpr std::size_t kPlainBits = 256;

std::size_t bit_count(const visibility::FaceCoverage& entry) {
  return static_cast<std::size_t>(entry.width) * static_cast<std::size_t>(entry.height);
}

std::size_t words_for(std::size_t bits) { return (bits + 63) / 64; }

class Packer {
 public:
  explicit Packer(std::vector<std::uint8_t>& out) : out_(out) {}

  /// Seven bits a byte, the lowest first; the eighth is set in all bytes but the last.
  void number(std::uint64_t value) {
    for (; value >= 128; value >>= 7) out_.push_back(static_cast<std::uint8_t>(value | 128));
    out_.push_back(static_cast<std::uint8_t>(value));
  }
  void bytes(const void* from, std::size_t count) {
    const auto* first = static_cast<const std::uint8_t*>(from);
    out_.insert(out_.end(), first, first + count);
  }

  void bits(std::span<const std::uint64_t> words, std::size_t count) {
    static_assert(std::endian::native == std::endian::little);
    if (count <= kPlainBits) return bytes(words.data(), (count + 7) / 8);
    // Runs: how many words are all 0, how many are all 1, and how many others follow.
    for (std::size_t i = 0; i < words.size();) {
      const std::size_t none = run(words, i, [](std::uint64_t w) { return w == kNone; });
      const std::size_t all = run(words, i + none, [](std::uint64_t w) { return w == kAll; });
      const std::size_t first = i + none + all;
      const std::size_t others = run(words, first, [](std::uint64_t w) { return w != kNone && w != kAll; });
      for (const std::size_t length : {none, all, others}) number(length);
      bytes(words.data() + first, others * sizeof(std::uint64_t));
      i = first + others;
    }
  }

 private:
  static std::size_t run(std::span<const std::uint64_t> words, std::size_t from, auto wanted) {
    std::size_t end = from;
    while (end < words.size() && wanted(words[end])) ++end;
    return end - from;
  }

  std::vector<std::uint8_t>& out_;
};

class Unpacker {
 public:
  explicit Unpacker(const PackedCoverage& packed)
      : view_(packed.view), at_(packed.bytes.data()), end_(at_ + packed.bytes.size()) {}

  bool done() const { return at_ == end_; }

  /// The next face; its bits come next.
  visibility::FaceCoverage entry() {
    visibility::FaceCoverage entry;
    face_ += static_cast<std::uint32_t>(number());
    entry.face = FaceId{face_};
    entry.view = view_;
    for (std::int32_t* value : {&entry.x0, &entry.y0, &entry.width, &entry.height})
      *value = static_cast<std::int32_t>(number());
    entry.visible = static_cast<std::uint32_t>(number());
    std::memcpy(&entry.visible_share, take(sizeof(float)), sizeof(float));
    return entry;
  }

  void skip_bits(std::size_t count) {
    if (count <= kPlainBits) {
      take((count + 7) / 8);
      return;
    }
    for (std::size_t left = words_for(count); left > 0;) {
      const std::size_t alike = number() + number(), others = number();
      take(others * sizeof(std::uint64_t));
      left -= alike + others;
    }
  }

  void bits(std::size_t count, std::uint64_t* words) {
    if (count == 0) return;
    const std::size_t whole = words_for(count);
    if (count <= kPlainBits) {
      words[whole - 1] = 0;
      std::memcpy(words, take((count + 7) / 8), (count + 7) / 8);
      return;
    }
    for (std::uint64_t* const end = words + whole; words != end;) {
      for (const std::uint64_t alike : {kNone, kAll}) words = std::fill_n(words, number(), alike);
      const std::size_t others = number();
      if (others == 0) continue;
      std::memcpy(words, take(others * sizeof(std::uint64_t)), others * sizeof(std::uint64_t));
      words += others;
    }
  }

 private:
  std::uint64_t number() {
    std::uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      const std::uint64_t byte = *at_++;
      value |= (byte & 127) << shift;
      if (byte < 128) return value;
    }
  }
  const std::uint8_t* take(std::size_t count) {
    const std::uint8_t* from = at_;
    at_ += count;
    return from;
  }

  ViewId view_;
  const std::uint8_t *at_, *end_;
  std::uint32_t face_ = 0;
};

// Reads what Unpacker reads, without trust.
class Checker {
 public:
  Checker(const PackedCoverage& packed, const Mesh& mesh, const View& view)
      : left_(packed.bytes), mesh_(mesh), view_(view) {}

  bool is_sound() {
    const std::uint64_t faces = mesh_.faces.size();
    for (std::uint64_t face = 0, entries = 0; !left_.empty(); ++entries) {
      const std::uint64_t step = number();
      if (step >= faces || (entries > 0 && step == 0) || (face += step) >= faces || !is_entry(face)) return false;
    }
    return true;
  }

 private:
  // The box, the count of samples and their share, and the bits.
  bool is_entry(std::uint64_t face) {
    const std::uint64_t x = number(), y = number(), width = number(), height = number(), visible = number();
    float share = 0;
    if (failed_ || left_.size() < sizeof share) return false;
    std::memcpy(&share, left_.data(), sizeof share);
    left_ = left_.subspan(sizeof share);
    if (!(share >= 0 && share <= 1) || visible > UINT32_MAX) return false;
    // The box of a face that only samples smaller than pixels see is empty, anywhere.
    constexpr std::uint64_t kMost = 1u << 20;
    if (width > kMost || height > kMost || x > UINT32_MAX || y > UINT32_MAX) return false;
    if (width > 0 && height > 0) {
      const PixelBox most = box_of(mesh_.faces[face]);
      if (!(static_cast<double>(x) >= most.x0 && static_cast<double>(y) >= most.y0 &&
            static_cast<double>(x + width) <= most.x1 && static_cast<double>(y + height) <= most.y1))
        return false;
    }
    return skip_bits(static_cast<std::size_t>(width * height)) && !failed_;
  }
  struct PixelBox {
    double x0, y0, x1, y1;
  };
  // The pixels of the frame that a face may have samples in: those whose centres its projection holds, and one more around for
  // methods that draw in float. All, if it reaches behind the camera.
  PixelBox box_of(const Triangle& face) const {
    const Camera& camera = view_.camera;
    const PixelBox frame{0, 0, static_cast<double>(camera.width), static_cast<double>(camera.height)};
    PixelBox box{frame.x1, frame.y1, 0, 0};
    for (const std::uint32_t v : face) {
      const auto p = pixel_from_world(view_, mesh_.positions[v]);
      if (!p) return frame;
      box = {std::min(box.x0, p->x), std::min(box.y0, p->y), std::max(box.x1, p->x), std::max(box.y1, p->y)};
    }
    return {std::max(0.0, std::floor(box.x0) - 1), std::max(0.0, std::floor(box.y0) - 1),
            std::min(frame.x1, std::ceil(box.x1) + 1), std::min(frame.y1, std::ceil(box.y1) + 1)};
  }
  bool skip_bits(std::size_t count) {
    if (count <= kPlainBits) return skip((count + 7) / 8);
    for (std::uint64_t words = words_for(count); words > 0;) {
      for (int kind = 0; kind < 3; ++kind) {
        const std::uint64_t length = number();
        if (length > words || (kind == 2 && !skip(length * sizeof(std::uint64_t)))) return false;
        words -= length;
      }
      if (failed_) return false;
    }
    return true;
  }
  bool skip(std::uint64_t bytes) {
    if (bytes > left_.size()) return false;
    left_ = left_.subspan(static_cast<std::size_t>(bytes));
    return true;
  }
  std::uint64_t number() {
    std::uint64_t value = 0;
    // None that is written is longer than five bytes.
    for (int shift = 0; shift < 35 && !left_.empty(); shift += 7) {
      const std::uint64_t byte = left_.front();
      left_ = left_.subspan(1);
      value |= (byte & 127) << shift;
      if (byte < 128) return value;
    }
    failed_ = true;
    return 0;
  }

  std::span<const std::uint8_t> left_;
  const Mesh& mesh_;
  const View& view_;
  bool failed_ = false;
};

}  // namespace

bool is_sound(const PackedCoverage& packed, const Mesh& mesh, const View& view) {
  return Checker(packed, mesh, view).is_sound();
}

PackedCoverage pack(ViewId view, const visibility::CoverageTable& coverage) {
  PackedCoverage packed{view, {}};
  Packer packer(packed.bytes);
  std::uint32_t face = 0;
  for (const visibility::FaceCoverage& entry : coverage.entries) {
    const auto own = static_cast<std::uint32_t>(index(entry.face));
    packer.number(own - face);
    face = own;
    for (const std::int32_t value : {entry.x0, entry.y0, entry.width, entry.height})
      packer.number(static_cast<std::uint32_t>(value));
    packer.number(entry.visible);
    packer.bytes(&entry.visible_share, sizeof entry.visible_share);
    const std::size_t bits = bit_count(entry);
    packer.bits(std::span(coverage.words).subspan(entry.first_word, words_for(bits)), bits);
  }
  packed.bytes.shrink_to_fit();
  return packed;
}

double CoverageStore::bytes() const {
  double sum = 0;
  for (const auto& view : views_) sum += static_cast<double>(view->bytes.capacity());
  return sum;
}

visibility::CoverageTable CoverageStore::of_partial_faces(std::span<const labeling::FaceTag> tags) const {
  // Calls visit(view, entry, unpacker) for every partial face; it must take or skip the bits.
  const auto for_each_view = [&](const auto& visit) {
    tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t v) {
      for (Unpacker from(*views_[v]); !from.done();) {
        const visibility::FaceCoverage entry = from.entry();
        if (tags[index(entry.face)] == labeling::FaceTag::partial)
          visit(v, entry, from);
        else
          from.skip_bits(bit_count(entry));
      }
    });
  };
  // Where the entries and the words of each view begin: first as counts, one place further on.
  std::vector<std::size_t> entries(views_.size() + 1, 0), words(views_.size() + 1, 0);
  for_each_view([&](std::size_t v, const visibility::FaceCoverage& entry, Unpacker& from) {
    ++entries[v + 1];
    words[v + 1] += words_for(bit_count(entry));
    from.skip_bits(bit_count(entry));
  });
  for (std::size_t v = 0; v < views_.size(); ++v) {
    entries[v + 1] += entries[v];
    words[v + 1] += words[v];
  }
  visibility::CoverageTable kept;
  kept.entries.resize(entries.back());
  kept.words.resize(words.back());
  for_each_view([&](std::size_t v, visibility::FaceCoverage entry, Unpacker& from) {
    entry.first_word = words[v];
    words[v] += words_for(bit_count(entry));
    from.bits(bit_count(entry), kept.words.data() + entry.first_word);
    kept.entries[entries[v]++] = entry;
  });
  return kept;
}

}  // namespace gpvc::pipeline
