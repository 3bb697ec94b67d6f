// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/offscreen_context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>

#include "core/base/error.h"

namespace cornice::viewer {
namespace {

/// `shared` or EGL_NO_CONTEXT: whose objects it sees.
EGLContext create_context(EGLDisplay display, EGLContext shared) {
  constexpr std::array<EGLint, 7> kWanted{EGL_CONTEXT_MAJOR_VERSION,
                                          4,
                                          EGL_CONTEXT_MINOR_VERSION,
                                          5,
                                          EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                          EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                          EGL_NONE};
  return eglCreateContext(display, EGL_NO_CONFIG_KHR, shared, kWanted.data());
}

class SecondOffscreenContext : public SecondContext {
 public:
  SecondOffscreenContext(EGLDisplay display, EGLContext context)
      : display_(display), context_(context) {}
  ~SecondOffscreenContext() override { eglDestroyContext(display_, context_); }
  bool make_current() override {
    eglBindAPI(EGL_OPENGL_API);  // each thread has its own
    return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }
  void release() override {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglReleaseThread();
  }

 private:
  EGLDisplay display_;
  EGLContext context_;
};

}  // namespace

struct OffscreenContext::State {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  ~State() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    eglTerminate(display);
  }
};

OffscreenContext::OffscreenContext() : state_(std::make_unique<State>()) {
  const auto fail = [](const std::string& what) {
    throw RunError("OpenGL", what + "; Debian's libegl1 and libgl1-mesa-dri draw without a GPU");
  };
  if (!epoxy_has_egl()) fail("there is no EGL library");
  const EGLDisplay none = EGL_NO_DISPLAY;
  if (epoxy_has_egl_extension(none, "EGL_EXT_device_base") &&
      epoxy_has_egl_extension(none, "EGL_EXT_platform_device")) {
    // The first device is the GPU where there is one.
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_TRUE)
      for (EGLint i = 0; i < count && state_->display == none; ++i) {
        const EGLDisplay display = eglGetPlatformDisplayEXT(
            EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)], nullptr);
        if (display != none && eglInitialize(display, nullptr, nullptr) == EGL_TRUE)
          state_->display = display;
      }
  }
  if (state_->display == none) {
    const EGLDisplay display =
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display == none || eglInitialize(display, nullptr, nullptr) != EGL_TRUE)
      fail("EGL finds no device to draw with");
    state_->display = display;
  }
  eglBindAPI(EGL_OPENGL_API);
  state_->context = create_context(state_->display, EGL_NO_CONTEXT);
  if (state_->context == EGL_NO_CONTEXT) fail("the driver has no OpenGL 4.5 core");
  if (eglMakeCurrent(state_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, state_->context) != EGL_TRUE)
    fail("the driver cannot draw without a window");
  require_gl_45();
}

OffscreenContext::~OffscreenContext() = default;

std::unique_ptr<SecondContext> OffscreenContext::second() const {
  const EGLContext context = create_context(state_->display, state_->context);
  if (context == EGL_NO_CONTEXT) return nullptr;
  return std::make_unique<SecondOffscreenContext>(state_->display, context);
}

std::string gl_description() {
  const auto text = [](GLenum what) {
    const GLubyte* value = glGetString(what);
    return std::string(value != nullptr ? reinterpret_cast<const char*>(value) : "unknown");
  };
  return text(GL_RENDERER) + ", " + text(GL_VERSION);
}

void require_gl_45() {
  if (epoxy_gl_version() < 45)
    throw RunError("OpenGL", "4.5 is needed, this is " + gl_description() +
                                 "; a newer driver, or LIBGL_ALWAYS_SOFTWARE=1, has it");
}

}  // namespace cornice::viewer
