// See open_module.hpp.
#include "solver/common/open_module.hpp"

#include "solver/common/failure.hpp"

#include <fmt/format.h>

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#if defined(HVI_SANITIZE)
// These libraries do not free all they take; the leak sanitizer is to tell of ours only.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libgmsh.so\nleak:libfontconfig.so\nleak:libpetsc\nleak:libmpi\nleak:libopen-\nleak:"
         "libpmix\nleak:libhwloc\n"
         "leak:libevent\nleak:mca_";
}
// What is left alone is not told: outputs are compared.
extern "C" const char* __lsan_default_options();
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
#endif

namespace hvi::solver {
namespace {

/// The shared object that this code is in, where it is not the program itself: Python's module.
std::filesystem::path own_library() {
  Dl_info found{};
  static const char inside = 0;
  if (dladdr(&inside, &found) == 0 || found.dli_fname == nullptr) return {};
  const std::filesystem::path file(found.dli_fname);
  return file.extension() == ".so" ? file : std::filesystem::path();
}

std::vector<std::filesystem::path> places(const ModuleFile& module) {
  if (const char* other = std::getenv(module.variable)) return {other};
  if (const auto library = own_library(); !library.empty()) {
    const auto packages =
        library.parent_path().parent_path(); // lib/python3/dist-packages/hvi/_hvi.so
    return {packages.parent_path() / module.file,
            packages.parent_path().parent_path() / "hvi" / module.file};
  }
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return {};
  const auto folder = program.parent_path();
  return {folder / module.file, folder.parent_path() / "lib" / "hvi" / module.file,
          folder.parent_path() / module.file};
}

/// It stays loaded: libgmsh and MPI do not survive being unloaded.
void* load(const ModuleFile& module) {
  std::string tried;
  for (const auto& path : places(module)) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) {
      tried += fmt::format("\n  {}: not there", path.string());
      continue;
    }
    if (void* const opened = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE))
      return opened;
    tried += fmt::format("\n  {}", dlerror());
  }
  throw Failure(FailureKind::missing_file, {},
                fmt::format("the module that {} cannot be loaded:{}", module.purpose, tried),
                module.help);
}

} // namespace

void* module_entry(const ModuleFile& module, const char* name) {
  void* const symbol = dlsym(load(module), name);
  if (!symbol)
    throw Failure(FailureKind::missing_file, {},
                  fmt::format("the module that {} has no function {}: it is of another version",
                              module.purpose, name));
  return symbol;
}

} // namespace hvi::solver
