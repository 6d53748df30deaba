#include "visibility/gl/ivm_gl.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "io/clock.h"

namespace gpvc::visibility {
namespace {

/// Faces per draw call: keeps gl_PrimitiveID and the index count below 2^31.
constexpr std::size_t kFacesPerDraw = std::size_t{1} << 28;

int texture_limit() {
  GLint texture = 0;
  std::array<GLint, 2> viewport{};
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport.data());
  return std::min({texture, viewport[0], viewport[1]});
}

}  // namespace

IvmRenderer::IvmRenderer(const Mesh& mesh, const Options& options)
    : mesh_(mesh), options_(options), box_(box_around(mesh)) {
  const int limit = texture_limit();
  options_.largest_tile = options.largest_tile > 0 ? std::min(options.largest_tile, limit) : limit;
  const std::array<ShaderStage, 2> stages{
      ShaderStage{GL_VERTEX_SHADER, {"raster.glsl", "ivm.vert"}},
      ShaderStage{GL_FRAGMENT_SHADER, {"ivm.frag"}},
  };
  program_ = make_program(stages);
  tile_origin_ = uniform_location(program_, "tile_origin");
  clip_from_pixel_ = uniform_location(program_, "clip_from_pixel");
  clip_from_depth_ = uniform_location(program_, "clip_from_depth");
  first_face_ = uniform_location(program_, "first_face");
  vertices_ = make_vertex_array();
  if (mesh.faces.empty() || mesh.positions.empty()) return;
  const Clock::time_point start = Clock::now();
  positions_ = make_buffer(std::span(mesh.positions), 0, "uploading the vertices");
  faces_ = make_buffer(std::span(mesh.faces), 0, "uploading the faces");
  glFinish();
  pending_upload_s_ = seconds_since(start);
  const GLuint array = vertices_.name();
  glVertexArrayVertexBuffer(array, 0, positions_.name(), 0, sizeof(WorldPoint));
  glVertexArrayElementBuffer(array, faces_.name());
  glVertexArrayAttribLFormat(array, 0, 3, GL_DOUBLE, 0);
  glVertexArrayAttribBinding(array, 0, 0);
  glEnableVertexArrayAttrib(array, 0);
  check_gl("preparing the mesh");
}

int IvmRenderer::tiles(const Camera& camera) const {
  return ((camera.width + options_.largest_tile - 1) / options_.largest_tile) *
         ((camera.height + options_.largest_tile - 1) / options_.largest_tile);
}

void IvmRenderer::make_target(int width, int height) {
  if (width == tile_width_ && height == tile_height_) return;
  target_ = {};
  color_ = make_texture_2d(GL_R32UI, width, height, "making the IVM");
  set_nearest(color_);
  depth_ = make_texture_2d(GL_DEPTH_COMPONENT32F, width, height, "making the depth buffer");
  target_ = make_framebuffer(color_.name(), depth_.name(), "making the IVM target");
  tile_width_ = width;
  tile_height_ = height;
}

IvmRenderer::Times IvmRenderer::render(const Camera& camera, const Pose& pose, const Output& output) {
  Times times;
  times.upload_s = std::exchange(pending_upload_s_, 0);
  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  if (output.faces != nullptr) output.faces->resize(pixels);
  if (output.depths != nullptr) output.depths->resize(pixels);
  make_target(std::min(camera.width, options_.largest_tile), std::min(camera.height, options_.largest_tile));
  const Clock::time_point begin = Clock::now();
  set_view(camera, pose);
  times.upload_s += seconds_since(begin);
  for (int y0 = 0; y0 < camera.height; y0 += tile_height_) {
    for (int x0 = 0; x0 < camera.width; x0 += tile_width_) {
      const Clock::time_point start = Clock::now();
      draw_tile(x0, y0);
      glFinish();
      times.render_s += seconds_since(start);
      const Clock::time_point drawn = Clock::now();
      read_tile(camera, x0, y0, output);
      times.readback_s += seconds_since(drawn);
    }
  }
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  check_gl("reading the IVM");
  return times;
}

void IvmRenderer::read_tile(const Camera& camera, int x0, int y0, const Output& output) {
  const PixelBox tile{x0, y0, std::min(x0 + tile_width_, camera.width), std::min(y0 + tile_height_, camera.height)};
  if (output.faces != nullptr) read_pixels(GL_RED_INTEGER, GL_UNSIGNED_INT, tile, camera.width, output.faces->data());
  if (output.depths != nullptr) read_pixels(GL_DEPTH_COMPONENT, GL_FLOAT, tile, camera.width, output.depths->data());
}

/// Reads four bytes per pixel of the tile into an image with rows of `stride` pixels.
void IvmRenderer::read_pixels(GLenum format, GLenum type, const PixelBox& tile, int stride, void* pixels) {
  constexpr std::size_t kBytes = 4;
  const int width = tile.x1 - tile.x0, height = tile.y1 - tile.y0;
  const auto row_bytes = kBytes * static_cast<std::size_t>(width);
  const auto row_at = [&](int row) {
    return static_cast<std::byte*>(pixels) +
           kBytes * (static_cast<std::size_t>(tile.y0 + row) * static_cast<std::size_t>(stride) +
                     static_cast<std::size_t>(tile.x0));
  };
  if (!options_.staged_reads) {
    glPixelStorei(GL_PACK_ROW_LENGTH, stride);
    glReadPixels(0, 0, width, height, format, type, row_at(0));
    glPixelStorei(GL_PACK_ROW_LENGTH, 0);
    return;
  }
  staging_.reserve(row_bytes * static_cast<std::size_t>(height));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, staging_.name());
  glReadPixels(0, 0, width, height, format, type, nullptr);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  const std::byte* from = staging_.wait();
  // A single thread copies more slowly than the bus delivers.
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 64), [&](const tbb::blocked_range<int>& rows) {
    for (int row = rows.begin(); row < rows.end(); ++row)
      std::memcpy(row_at(row), from + row_bytes * static_cast<std::size_t>(row), row_bytes);
  });
}

void IvmRenderer::set_view(const Camera& camera, const Pose& pose) {
  mapping_ = depth_mapping(options_.projection, options_.near, box_, pose);
  const WindowDepth& window = mapping_.window;
  set_camera(program_, camera, pose);
  // Clip z is the window depth times w, or twice that minus w where clip space is symmetric.
  if (mapping_.projection == Projection::spc) {
    glProgramUniform2d(program_.name(), clip_from_depth_, 2 * window.at_infinity - 1, 2 * window.per_inverse_z);
  } else {
    glProgramUniform2d(program_.name(), clip_from_depth_, window.at_infinity, window.per_inverse_z);
  }
}

void IvmRenderer::set_depth_state() const {
  const bool symmetric = mapping_.projection == Projection::spc;
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(symmetric ? GL_LESS : GL_GREATER);
  // Pixel row 0 is window row 0 and comes first when read back, so nothing is flipped.
  glClipControl(GL_LOWER_LEFT, symmetric ? GL_NEGATIVE_ONE_TO_ONE : GL_ZERO_TO_ONE);
  const GLfloat farthest = symmetric ? 1 : 0;
  glClearBufferfv(GL_DEPTH, 0, &farthest);
}

void IvmRenderer::draw_tile(int x0, int y0) {
  glBindFramebuffer(GL_FRAMEBUFFER, target_.name());
  // Every tile uses the same viewport size, so that a pixel is the same step in normalized device coordinates.
  glViewport(0, 0, tile_width_, tile_height_);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  glDisable(GL_MULTISAMPLE);
  set_depth_state();
  const std::array<GLuint, 4> nothing{index(kNoFace), 0, 0, 0};
  glClearBufferuiv(GL_COLOR, 0, nothing.data());
  if (!mesh_.faces.empty()) {
    glUseProgram(program_.name());
    glUniform2d(tile_origin_, x0, y0);
    glUniform2d(clip_from_pixel_, 2.0 / tile_width_, 2.0 / tile_height_);
    draw_faces();
    glUseProgram(0);
  }
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  glDisable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  check_gl("drawing the IVM");
}

void IvmRenderer::draw_faces() {
  glBindVertexArray(vertices_.name());
  for (std::size_t first = 0; first < mesh_.faces.size(); first += kFacesPerDraw) {
    const std::size_t count = std::min(kFacesPerDraw, mesh_.faces.size() - first);
    glUniform1ui(first_face_, static_cast<GLuint>(first));
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * count), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(first * sizeof(Triangle)));
  }
  glBindVertexArray(0);
}

}  // namespace gpvc::visibility
