// OpenGL 4.5 objects with owners. All calls need a current context (GraphicsDevice::make_current()); libepoxy looks the
// functions up at run time.
#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/scene.h"
#include "visibility/device.h"

namespace gpvc::visibility {

/// Throws GpuError "STAGE: GL_CODE" when an OpenGL error is pending (and clears all pending ones).
void check_gl(std::string_view stage);

/// A GL name and the function that deletes it. Move-only.
template <void (*remove)(GLuint)>
class GlObject {
 public:
  GlObject() = default;
  explicit GlObject(GLuint name) : name_(name) {}
  ~GlObject() {
    if (name_ != 0) remove(name_);
  }
  GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  GLuint name() const { return name_; }

 private:
  GLuint name_ = 0;
};

namespace gl_delete {
inline void buffer(GLuint name) { glDeleteBuffers(1, &name); }
inline void texture(GLuint name) { glDeleteTextures(1, &name); }
inline void framebuffer(GLuint name) { glDeleteFramebuffers(1, &name); }
inline void vertex_array(GLuint name) { glDeleteVertexArrays(1, &name); }
inline void program(GLuint name) { glDeleteProgram(name); }
}  // namespace gl_delete

using GlBuffer = GlObject<gl_delete::buffer>;
using GlTexture = GlObject<gl_delete::texture>;
using GlFramebuffer = GlObject<gl_delete::framebuffer>;
using GlVertexArray = GlObject<gl_delete::vertex_array>;
using GlProgram = GlObject<gl_delete::program>;

/// An immutable buffer (glNamedBufferStorage) of `bytes` > 0; `data` may be nullptr. Throws GpuError.
GlBuffer make_buffer(std::size_t bytes, const void* data, GLbitfield flags, std::string_view stage);

template <class T>
GlBuffer make_buffer(std::span<const T> values, GLbitfield flags, std::string_view stage) {
  return make_buffer(values.size_bytes(), values.data(), flags, stage);
}

/// Memory that the device copies to and the host reads, mapped as long as it lives. A graphics card copies to it at the
/// speed of the bus, without the driver's detour through pageable memory, and the buffers that shaders write to stay on
/// the card. A software renderer is faster without it.
class GlReadBuffer {
 public:
  /// Makes room for `bytes`; the contents are lost when it grows. Throws GpuError.
  void reserve(std::size_t bytes);
  GLuint name() const { return buffer_.name(); }
  /// Waits for all commands so far and returns the contents.
  const std::byte* wait() const;

 private:
  GlBuffer buffer_;
  const std::byte* mapped_ = nullptr;
  std::size_t bytes_ = 0;
};

/// An immutable 2D texture of one level. Throws GpuError (out of memory, above GL_MAX_TEXTURE_SIZE).
GlTexture make_texture_2d(GLenum internal_format, int width, int height, std::string_view stage);

/// Shaders can read integer textures only without filtering.
inline void set_nearest(const GlTexture& texture) {
  glTextureParameteri(texture.name(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(texture.name(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

/// A framebuffer with one colour texture and a depth texture. Throws GpuError when incomplete.
GlFramebuffer make_framebuffer(GLuint color_texture, GLuint depth_texture, std::string_view stage);

GlVertexArray make_vertex_array();

/// A file of shaders/, embedded in the program: shader_source("ivm.vert"). Throws std::logic_error for an unknown name.
std::string_view shader_source(std::string_view file);

struct ShaderStage {
  GLenum type = 0;  ///< GL_VERTEX_SHADER, ...
  /// Files of shaders/ compiled as one text, in this order, after "#version 450 core" (the files have none).
  std::vector<std::string_view> files;
};

/// Compiles and links. `defines` ("NAME VALUE", one a line) follow the version line. Throws GpuError with the driver's
/// log.
GlProgram make_program(std::span<const ShaderStage> stages, std::string_view defines = {});

/// Location of an active uniform; throws GpuError when there is none.
GLint uniform_location(const GlProgram& program, const char* name);

/// Sets the uniforms of project() in shaders/raster.glsl.
void set_camera(const GlProgram& program, const Camera& camera, const Pose& pose);

}  // namespace gpvc::visibility
