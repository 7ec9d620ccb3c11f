# SuiteSparse 5 has no CMake configuration of its own. Defines SuiteSparse::CHOLMOD and SuiteSparse::UMFPACK.
include(FindPackageHandleStandardArgs)
find_path(SuiteSparse_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
foreach(part CHOLMOD UMFPACK)
    string(TOLOWER ${part} name)
    find_library(SuiteSparse_${part}_LIBRARY ${name})
    list(APPEND SuiteSparse_NEEDED SuiteSparse_${part}_LIBRARY)
    if(SuiteSparse_${part}_LIBRARY AND NOT TARGET SuiteSparse::${part})
        add_library(SuiteSparse::${part} UNKNOWN IMPORTED)
        set_target_properties(SuiteSparse::${part} PROPERTIES
            IMPORTED_LOCATION ${SuiteSparse_${part}_LIBRARY}
            INTERFACE_INCLUDE_DIRECTORIES ${SuiteSparse_INCLUDE_DIR})
    endif()
endforeach()
find_package_handle_standard_args(SuiteSparse REQUIRED_VARS SuiteSparse_INCLUDE_DIR ${SuiteSparse_NEEDED})
