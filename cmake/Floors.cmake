# The floors of the house. A module may include its own headers and those of the modules it stands on, and of all that these stand
# on. The libraries are linked by this list, and the test house:floors fails on any other include.

# hvi_floor(solver/mesh ON solver/common)
function(hvi_floor module)
  cmake_parse_arguments(ARG "" "" "ON" ${ARGN})
  string(REPLACE "/" "_" target ${module})
  list(TRANSFORM ARG_ON REPLACE "/" "_")
  set_property(GLOBAL PROPERTY hvi_floor_${target} ${ARG_ON})
endfunction()

# The libraries that hvi_TARGET stands on
function(hvi_stands_on libraries target)
  get_property(floors GLOBAL PROPERTY hvi_floor_${target})
  list(TRANSFORM floors PREPEND hvi_)
  set(${libraries} ${floors} PARENT_SCOPE)
endfunction()

hvi_floor(solver/common)
hvi_floor(solver/kernel ON solver/common)
hvi_floor(solver/linear ON solver/common)
hvi_floor(solver/mesh ON solver/common)
hvi_floor(solver/law ON solver/kernel solver/mesh)
hvi_floor(solver/plan ON solver/law)
hvi_floor(solver/history ON solver/kernel solver/linear)
hvi_floor(solver/fem ON solver/plan solver/linear)
hvi_floor(solver/assembly ON solver/fem)
hvi_floor(solver/inequality ON solver/law solver/linear)
hvi_floor(solver/output ON solver/mesh)
hvi_floor(solver/time ON solver/assembly solver/inequality solver/history solver/output)
hvi_floor(solver/hypotheses ON solver/time)
hvi_floor(solver/study ON solver/time)

hvi_floor(lang/diag ON solver/common)
hvi_floor(lang/syntax ON lang/diag)
hvi_floor(lang/check ON lang/syntax solver/fem)
hvi_floor(lang/lower ON lang/check)
hvi_floor(lang ON lang/lower solver/hypotheses solver/study)
hvi_floor(lang/cli ON lang)
