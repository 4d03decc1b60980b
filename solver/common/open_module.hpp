// Modules of the program that are opened when they are asked for only, so that other runs do not
// pay for the libraries behind them.
#pragma once

#include <string>

namespace hvi::solver {

struct ModuleFile {
  const char* file;     ///< "libhvi_gmsh.so"
  const char* variable; ///< of the environment: names another file; the tests use it
  const char* purpose;  ///< "makes meshes with gmsh"
  const char* help;     ///< what to install
};

/// The function `name` of the module, which stays loaded until the program ends. Looked for beside
/// the program (build tree), one folder up (test programs), and where it is installed; from a
/// shared object (Python's module), by that one's place. Throws Failure(missing_file).
void* module_entry(const ModuleFile& module, const char* name);

/// The same as a function of this type.
template <class Function>
Function module_function(const ModuleFile& module, const char* name) {
  return reinterpret_cast<Function>(module_entry(module, name));
}

} // namespace hvi::solver
