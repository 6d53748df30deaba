// Wavefront OBJ with its MTL. Texture origin is the lower left corner there, so v is turned over.
#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "io/meshes/normals.h"
#include "io/output_file.h"
#include "io/textured_model.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

/// Text collected in one block between writes.
class TextOut {
 public:
  explicit TextOut(const fs::path& file) : out_(file) { block_.reserve(kBlock); }

  TextOut& text(std::string_view text) {
    reserve(text.size());
    block_.append(text);
    return *this;
  }
  template <typename Number>
  TextOut& number(Number value) {
    constexpr std::size_t kLongest = 32;  // of a shortest round-trip double or an integer
    std::array<char, kLongest> digits;
    const std::to_chars_result end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    return text({digits.data(), static_cast<std::size_t>(end.ptr - digits.data())});
  }
  /// With six decimals.
  TextOut& rounded(double value) {
    constexpr std::size_t kLongest = 340;  // of a double
    std::array<char, kLongest> digits;
    const std::to_chars_result end =
        std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed, 6);
    return text({digits.data(), static_cast<std::size_t>(end.ptr - digits.data())});
  }
  void commit() {
    out_.write(block_);
    out_.commit();
  }

 private:
  static constexpr std::size_t kBlock = std::size_t{1} << 20;
  void reserve(std::size_t bytes) {
    if (block_.size() + bytes <= kBlock) return;
    out_.write(block_);
    block_.clear();
  }

  OutputFile out_;
  std::string block_;
};

/// A page's file as the MTL names it: relative, '/'-separated.
std::string name_beside(const fs::path& page, const fs::path& obj_file) {
  const fs::path folder = fs::absolute(obj_file).lexically_normal().parent_path();
  const fs::path relative = fs::absolute(page).lexically_normal().lexically_relative(folder);
  return (relative.empty() ? page : relative).generic_string();
}

std::string material_name(ObjStyle style, std::span<const PageFile> pages, std::size_t page) {
  if (!pages[page].material.empty()) return pages[page].material;
  const std::string number = std::to_string(page);
  if (style == ObjStyle::exact) return "page_" + number;
  return "material" + std::string(4 - std::min<std::size_t>(number.size(), 4), '0') + number;
}

void write_mtl(const fs::path& mtl_file, const fs::path& obj_file, std::span<const PageFile> pages,
               bool with_untextured, ObjStyle style) {
  TextOut out(mtl_file);
  for (std::size_t page = 0; page < pages.size(); ++page) {
    if (page > 0) out.text("\n");
    out.text("newmtl ").text(material_name(style, pages, page));
    // White, no highlight, no shading: the photo's light is in the texture already.
    out.text("\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 0\nmap_Kd ").text(name_beside(pages[page].file, obj_file));
    out.text("\n");
  }
  if (with_untextured) out.text("\nnewmtl untextured\nKa 1 1 1\nKd 0.5 0.5 0.5\nKs 0 0 0\nillum 0\n");
  out.commit();
}

void write_vertices(TextOut& out, const TexturedModel& model, const ModelOptions& options) {
  const WorldPoint& offset = options.offset;
  const bool exact = options.obj_style == ObjStyle::exact;
  const auto number = [&](auto value) { exact ? out.number(value) : out.rounded(static_cast<double>(value)); };
  for (const WorldPoint& p : model.mesh->written_positions()) {
    out.text("v ");
    number(p.x - offset.x);
    out.text(" ");
    number(p.y - offset.y);
    out.text(" ");
    number(p.z - offset.z);
    out.text("\n");
  }
  const auto write_texcoord = [&](const TexCoord& t) {
    out.text("vt ");
    number(t.u);
    out.text(" ");
    number(1.0f - t.v);
    out.text("\n");
  };
  for (const auto& [u, v] : model.obj_texcoords) {
    out.text("vt ");
    number(u);
    out.text(" ");
    number(v);
    out.text("\n");
  }
  if (model.obj_texcoords.empty())
    for (const TexCoord& t : model.texcoords) write_texcoord(t);
  // odm_orthophoto takes equal counts for a model whose vertices have one texture coordinate each, in their order.
  if (!exact && model.texcoords.size() == model.mesh->positions.size()) write_texcoord({});
  if (!options.normals) return;
  for (const auto& n : vertex_normals(*model.mesh))
    out.text("vn ").number(n[0]).text(" ").number(n[1]).text(" ").number(n[2]).text("\n");
}

/// The faces in the order in which they are written.
std::vector<std::uint32_t> face_order(const TexturedModel& model, const ModelOptions& options) {
  std::vector<std::uint32_t> order;
  order.reserve(model.face_page.size());
  for (std::uint32_t f = 0; f < model.face_page.size(); ++f)
    if (model.face_page[f] != kNoPage || options.pageless_faces) order.push_back(f);
  if (options.obj_style == ObjStyle::texrecon)
    std::ranges::stable_sort(order, {}, [&](std::uint32_t f) { return model.face_page[f]; });
  return order;
}

/// Normals are numbered as positions are.
void write_faces(TextOut& out, const TexturedModel& model, std::span<const PageFile> pages,
                 const ModelOptions& options) {
  std::optional<std::uint32_t> last;
  for (const std::uint32_t f : face_order(model, options)) {
    const std::uint32_t page = model.face_page[f];
    if (page != last) {
      last = page;
      if (page == kNoPage)
        out.text("usemtl untextured\n");
      else
        out.text("usemtl ").text(material_name(options.obj_style, pages, page)).text("\n");
    }
    out.text("f");
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint64_t position = std::uint64_t{model.mesh->faces[f][corner]} + 1;
      out.text(" ").number(position);
      if (page != kNoPage) out.text("/").number(std::uint64_t{model.face_texcoords[f][corner]} + 1);
      if (options.normals) out.text(page == kNoPage ? "//" : "/").number(position);
    }
    out.text("\n");
  }
}

}  // namespace

void write_obj(const fs::path& obj_file, const TexturedModel& model, std::span<const PageFile> pages,
               const ModelOptions& options) {
  check_model(model, pages.size());
  fs::path mtl_file = obj_file;
  mtl_file.replace_extension(".mtl");
  TextOut out(obj_file);
  const auto& face_page = model.face_page;
  write_mtl(mtl_file, obj_file, pages,
            options.pageless_faces && std::ranges::find(face_page, kNoPage) != face_page.end(), options.obj_style);
  out.text("mtllib ").text(mtl_file.filename().string()).text("\n");
  write_vertices(out, model, options);
  write_faces(out, model, pages, options);
  out.commit();
}

void check_model(const TexturedModel& model, std::size_t page_count) {
  const std::size_t faces = model.mesh->faces.size();
  if (model.face_texcoords.size() != faces || model.face_page.size() != faces)
    throw std::invalid_argument("TexturedModel: face_texcoords and face_page must have one entry a face");
  if (!model.obj_texcoords.empty() && model.obj_texcoords.size() != model.texcoords.size())
    throw std::invalid_argument("TexturedModel: obj_texcoords must be empty or have one entry a texture coordinate");
  for (std::size_t f = 0; f < faces; ++f) {
    if (model.face_page[f] == kNoPage) continue;
    if (model.face_page[f] >= page_count) throw std::invalid_argument("TexturedModel: a face's page does not exist");
    for (const std::uint32_t t : model.face_texcoords[f])
      if (t >= model.texcoords.size())
        throw std::invalid_argument("TexturedModel: a face's texture coordinate does not exist");
  }
}

}  // namespace gpvc::io
