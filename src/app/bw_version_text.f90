module bw_version_text
  !! What `beamwave --version` prints.
  use bw_result_header, only: source_text
  use bw_version, only: program_build, program_compiler, program_libraries, program_native
  implicit none (type, external)
  private
  public :: version_text

contains

  pure function version_text() result(text)
    !! What `beamwave --version` prints: program, commit, compiler, libraries.
    character(:), allocatable :: text
    character(*), parameter :: nl = new_line('a')
    text = source_text()//nl// &
      'compiler    '//program_compiler//nl// &
      'build       '//program_build//', '
    if (program_native) then
      text = text//'tuned for the processor it was built on'//nl
    else
      text = text//'for any processor of its kind'//nl
    end if
    text = text//'libraries   '//program_libraries//nl
  end function version_text

end module bw_version_text
