#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>

#include "visibility/gl/gl_objects.h"
#include "visibility/raster/projection.h"

namespace gpvc::visibility {
namespace {

// As in ivm_gl.cpp: depth is kNear / z in a float, whose relative step is the same at any scale.
constexpr float kNear = 0x1p-64F;

struct Corner {
  float x, y, z;  // clip x and y; distance in front of the camera, the clip w
  float u, v;
};
static_assert(sizeof(Corner) == 5 * sizeof(float));

// A rectangle of the picture that is drawn at once.
struct Tile {
  int x0 = 0, y0 = 0, width = 0, height = 0;
};

struct PageFaces {
  bool textured = false;
  std::size_t page = 0;
  std::vector<std::size_t> faces;
};

// The faces of each page in face order; those without a page come last.
std::vector<PageFaces> faces_by_page(const io::TexturedModel& model, std::size_t pages) {
  std::vector<PageFaces> groups(pages + 1);
  for (std::size_t page = 0; page < pages; ++page) groups[page] = {true, page, {}};
  for (std::size_t face = 0; face < model.face_page.size(); ++face)
    groups[std::min<std::size_t>(model.face_page[face], pages)].faces.push_back(face);
  std::erase_if(groups, [](const PageFaces& group) { return group.faces.empty(); });
  return groups;
}

std::vector<Corner> corners(const io::TexturedModel& model, const PageFaces& group,
                            const std::vector<ProjectedVertex>& projected, const Tile& tile) {
  std::vector<Corner> result(3 * group.faces.size());
  const double scale_x = 2.0 / tile.width, scale_y = 2.0 / tile.height;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, group.faces.size(), 4096), [&](const auto& range) {
    for (std::size_t n = range.begin(); n != range.end(); ++n) {
      const std::size_t face = group.faces[n];
      for (std::size_t c = 0; c < 3; ++c) {
        const ProjectedVertex& p = projected[model.mesh->faces[face][c]];
        const io::TexCoord uv = group.textured ? model.texcoords[model.face_texcoords[face][c]] : io::TexCoord{};
        result[3 * n + c] = {static_cast<float>((p.u - tile.x0 * p.z) * scale_x - p.z),
                             static_cast<float>((p.v - tile.y0 * p.z) * scale_y - p.z), static_cast<float>(p.z), uv.u,
                             uv.v};
      }
    }
  });
  return result;
}

// Each block of `factor` x `factor` pixels becomes its mean; blocks at the right and lower edge may be smaller, so that
// texture coordinates keep their meaning to within half a block there.
Image shrunk(const Image& image, int factor) {
  Image small;
  small.width = (image.width + factor - 1) / factor;
  small.height = (image.height + factor - 1) / factor;
  small.pixels.resize(static_cast<std::size_t>(small.width) * static_cast<std::size_t>(small.height) * 3);
  tbb::parallel_for(0, small.height, [&](int y) {
    for (int x = 0; x < small.width; ++x) {
      std::array<int, 3> sum{};
      int count = 0;
      for (int v = y * factor; v < std::min((y + 1) * factor, image.height); ++v)
        for (int u = x * factor; u < std::min((x + 1) * factor, image.width); ++u, ++count)
          for (std::size_t c = 0; c < 3; ++c) sum[c] += image.at(u, v)[c];
      for (std::size_t c = 0; c < 3; ++c) small.at(x, y)[c] = static_cast<std::uint8_t>((sum[c] + count / 2) / count);
    }
  });
  return small;
}

GlTexture page_texture(const Image& page, bool mipmaps, int limit) {
  const int largest = std::max(page.width, page.height);
  if (largest > limit) return page_texture(shrunk(page, (largest + limit - 1) / limit), mipmaps, limit);
  const int levels = mipmaps ? static_cast<int>(std::bit_width(static_cast<unsigned>(largest))) : 1;
  GlTexture texture = make_texture_2d(GL_RGB8, page.width, page.height, levels, "making a texture page");
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture.name(), 0, 0, 0, page.width, page.height, GL_RGB, GL_UNSIGNED_BYTE, page.pixels.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureParameteri(texture.name(), GL_TEXTURE_MIN_FILTER, mipmaps ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
  glTextureParameteri(texture.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(texture.name(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(texture.name(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  if (mipmaps) glGenerateTextureMipmap(texture.name());
  check_gl("uploading a texture page");
  return texture;
}

class ModelRenderer {
 public:
  ModelRenderer() : vertices_(make_vertex_array()) {
    const std::array<ShaderStage, 2> stages{ShaderStage{GL_VERTEX_SHADER, {"model.vert"}},
                                            ShaderStage{GL_FRAGMENT_SHADER, {"model.frag"}}};
    program_ = make_program(stages);
    textured_ = uniform_location(program_, "textured");
    background_ = uniform_location(program_, "background");
    glProgramUniform1f(program_.name(), uniform_location(program_, "near_m"), kNear);
    glProgramUniform1i(program_.name(), uniform_location(program_, "page"), 0);
    const GLuint array = vertices_.name();
    glVertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribFormat(array, 1, 2, GL_FLOAT, GL_FALSE, offsetof(Corner, u));
    for (GLuint attribute : {0u, 1u}) {
      glVertexArrayAttribBinding(array, attribute, 0);
      glEnableVertexArrayAttrib(array, attribute);
    }
    std::array<GLint, 2> viewport{};
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture_limit_);
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport.data());
    largest_tile_ = std::min({texture_limit_, viewport[0], viewport[1]});
  }

  int texture_limit() const { return texture_limit_; }
  int largest_tile() const { return largest_tile_; }

  // Makes a cleared target of the tile's size and the state the draws need.
  void begin(const Tile& tile, bool cull, std::array<std::uint8_t, 3> background) {
    target_ = {};
    color_ = make_texture_2d(GL_RGBA8, tile.width, tile.height, 1, "making the picture");
    depth_ = make_texture_2d(GL_DEPTH_COMPONENT32F, tile.width, tile.height, 1, "making the depth buffer");
    target_ = make_framebuffer(color_.name(), depth_.name(), "making the picture's target");
    glBindFramebuffer(GL_FRAMEBUFFER, target_.name());
    glViewport(0, 0, tile.width, tile.height);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_GREATER);
    // Window row 0 is the picture's first row: no flip, but what is counter-clockwise to the eye is clockwise here.
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glFrontFace(GL_CW);
    glCullFace(GL_BACK);
    (cull ? glEnable : glDisable)(GL_CULL_FACE);
    std::array<float, 4> clear{};
    for (std::size_t c = 0; c < 3; ++c) clear[c] = static_cast<float>(background[c]) / 255.0F;
    const GLfloat farthest = 0;
    glClearBufferfv(GL_COLOR, 0, clear.data());
    glClearBufferfv(GL_DEPTH, 0, &farthest);
    glUseProgram(program_.name());
    glUniform3f(background_, clear[0], clear[1], clear[2]);
    glBindVertexArray(vertices_.name());
  }

  void draw(std::span<const Corner> triangles, const GlTexture& page) {
    const GlBuffer buffer = make_buffer(triangles, 0, "uploading a page's faces");
    glVertexArrayVertexBuffer(vertices_.name(), 0, buffer.name(), 0, sizeof(Corner));
    glBindTextureUnit(0, page.name());
    glUniform1i(textured_, page.name() != 0 ? 1 : 0);
    // At most 2^30 corners a call: the count is a signed int.
    constexpr std::size_t kCorners = 3 * (std::size_t{1} << 28);
    for (std::size_t first = 0; first < triangles.size(); first += kCorners)
      glDrawArrays(GL_TRIANGLES, static_cast<GLint>(first),
                   static_cast<GLsizei>(std::min(kCorners, triangles.size() - first)));
    check_gl("drawing a page's faces");
  }

  void read(const Tile& tile, RenderResult& result) {
    std::vector<std::uint8_t> rgba(4 * static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(tile.height));
    glReadPixels(0, 0, tile.width, tile.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
    check_gl("reading the picture");
    tbb::parallel_for(0, tile.height, [&](int y) {
      const std::uint8_t* from = rgba.data() + 4 * static_cast<std::size_t>(y) * static_cast<std::size_t>(tile.width);
      std::uint8_t* to = result.image.at(tile.x0, tile.y0 + y);
      std::uint8_t* textured = result.textured.data() + (to - result.image.pixels.data()) / 3;
      for (int x = 0; x < tile.width; ++x, from += 4, to += 3) {
        std::copy(from, from + 3, to);
        *textured++ = from[3];
      }
    });
  }

  void end() {
    glBindVertexArray(0);
    glUseProgram(0);
    glBindTextureUnit(0, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glFrontFace(GL_CCW);
    glDisable(GL_CULL_FACE);
    glDisable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
  }

 private:
  GlProgram program_;
  GlVertexArray vertices_;
  GlTexture color_, depth_;
  GlFramebuffer target_;
  GLint textured_ = 0, background_ = 0, texture_limit_ = 0;
  int largest_tile_ = 0;
};

}  // namespace

RenderResult render_model(GraphicsDevice& device, const io::TexturedModel& model, const std::vector<Image>& pages,
                          const Camera& camera, const Pose& pose, bool mipmaps, bool cull,
                          std::array<std::uint8_t, 3> background) {
  assert(model.mesh != nullptr && model.face_page.size() == model.mesh->faces.size());
  device.make_current();
  RenderResult result;
  result.image.width = camera.width;
  result.image.height = camera.height;
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  result.image.pixels.resize(3 * pixels);
  result.textured.resize(pixels);

  std::vector<ProjectedVertex> projected;
  project_vertices(*model.mesh, camera, pose, projected);
  const std::vector<PageFaces> groups = faces_by_page(model, pages.size());
  ModelRenderer renderer;
  const int step = renderer.largest_tile();
  for (int y0 = 0; y0 < camera.height; y0 += step)
    for (int x0 = 0; x0 < camera.width; x0 += step) {
      const Tile tile{x0, y0, std::min(step, camera.width - x0), std::min(step, camera.height - y0)};
      renderer.begin(tile, cull, background);
      for (const PageFaces& group : groups) {  // one page on the device at a time
        GlTexture page;
        if (group.textured) page = page_texture(pages[group.page], mipmaps, renderer.texture_limit());
        renderer.draw(corners(model, group, projected, tile), page);
      }
      renderer.read(tile, result);
      renderer.end();
    }
  return result;
}

}  // namespace gpvc::visibility
