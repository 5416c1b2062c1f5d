# Targets for find_package(rebound_sampler):
#
#   rebound_sampler::rebound_sampler   the functions of rebound_sampler.h, for C and C++
#   rebound_sampler::fortran           the module rebound_sampler, if the project has the language Fortran
#
# Your own build compiles them from the sources beside this file: a Fortran module fits one compiler only.

if(TARGET rebound_sampler)
  return()
endif()
if(NOT CMAKE_C_COMPILER_LOADED)
  set(rebound_sampler_FOUND FALSE)
  set(rebound_sampler_NOT_FOUND_MESSAGE "the header is compiled as C; add C to the LANGUAGES of your project")
  return()
endif()

add_library(rebound_sampler STATIC "${CMAKE_CURRENT_LIST_DIR}/rebound_sampler.c")
add_library(rebound_sampler::rebound_sampler ALIAS rebound_sampler)
set_target_properties(rebound_sampler PROPERTIES POSITION_INDEPENDENT_CODE ON)
target_include_directories(rebound_sampler PUBLIC "${CMAKE_CURRENT_LIST_DIR}")
target_link_libraries(rebound_sampler PUBLIC m)
# also in a build without a type, which would not optimise at all
target_compile_options(rebound_sampler PRIVATE "$<$<C_COMPILER_ID:GNU,Clang,AppleClang>:-O3>")

if(CMAKE_Fortran_COMPILER_LOADED)
  set(rebound_sampler_modules "${CMAKE_CURRENT_BINARY_DIR}/rebound_sampler_modules")
  add_library(rebound_sampler_fortran STATIC "${CMAKE_CURRENT_LIST_DIR}/rebound_sampler.f90")
  add_library(rebound_sampler::fortran ALIAS rebound_sampler_fortran)
  set_target_properties(rebound_sampler_fortran PROPERTIES
    POSITION_INDEPENDENT_CODE ON
    Fortran_MODULE_DIRECTORY "${rebound_sampler_modules}")
  target_include_directories(rebound_sampler_fortran PUBLIC "${rebound_sampler_modules}")
  target_link_libraries(rebound_sampler_fortran PUBLIC rebound_sampler)
endif()
