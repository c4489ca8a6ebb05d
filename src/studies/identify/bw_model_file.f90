module bw_model_file
  !! What a beam says of its record, put into the result of the record.
  use bw_case_result, only: case_done, case_misfit
  use bw_child_process, only: child_process
  use bw_error, only: error_type
  use bw_fit_search, only: misfit_type
  use bw_identification, only: identification
  use bw_identified_scene, only: identified_attribute
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_model_comparison, only: compared_lines
  use bw_netcdf_path, only: plain_path
  use bw_netcdf_reading, only: close_netcdf, of_the_file, open_netcdf, read_text
  use bw_study_file, only: study_file
  use bw_text, only: append, string
  use netcdf, only: nf90_char, nf90_def_var, nf90_get_var, nf90_inq_dimid, nf90_inq_varid, nf90_inquire_dimension, nf90_noerr, &
    nf90_open, nf90_put_var, nf90_write
  implicit none (type, external)
  private
  public :: read_attribute, put_model

  integer, parameter :: most_seconds = 5       !! of processor time to read an attribute

  type, public :: model_findings
    !! All that is written.
    type(compared_lines), allocatable :: cases(:)        !! of the scene, (cases)
    type(misfit_type), allocatable :: misfits(:)         !! one of all cases that were fitted together, else of each
    type(identification), allocatable :: found           !! unallocated where nothing was identified
    type(string), allocatable :: scenes(:)               !! texts of the identified scenes: the scene's own, then further ones
    character(:), allocatable :: identity                !! of what it rests on beside the result
    character(:), allocatable :: report, notes           !! of the result and the model
  contains
    procedure :: trusted
  end type model_findings

contains

  pure logical function trusted(self)
    !! What was identified, if anything, explains the lines.
    class(model_findings), intent(in) :: self
    trusted = .true.
    if (allocated(self%found)) trusted = self%found%explained
  end function trusted

  subroutine put_model(path, findings, error)
    !! Put the findings into a result that is whole but has not its name yet.
    !! **Errors**: `status_bad_file` where it cannot be read or written.
    character(*), intent(in) :: path
    type(model_findings), intent(in) :: findings
    type(error_type), allocatable, intent(inout) :: error
    type(study_file) :: file
    integer :: i
    file%path = path
    call file%check(nf90_open(plain_path(path), nf90_write, file%id), error)
    call put_comparison(file, findings, error)
    if (allocated(findings%found)) call put_identified(file, findings%found, error)
    do i = 1, size(findings%scenes)
      call file%put_text(identified_attribute(i), findings%scenes(i)%text, error)
    end do
    if (.not. findings%trusted()) call put_status(file, size(findings%cases), error)
    call file%put_text('model', findings%identity, error)
    call file%finish(findings%notes(:max(0, len(findings%notes) - 1)), findings%report, error)
  end subroutine put_model

  subroutine put_status(file, cases, error)
    !! The cases whose lines the identified beam does not explain say so.
    type(study_file), intent(in) :: file
    integer, intent(in) :: cases
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable, status(cases)
    if (allocated(error)) return
    call file%check(nf90_inq_varid(file%id, 'case_status', variable), error)
    if (.not. allocated(error)) call file%check(nf90_get_var(file%id, variable, status), error)
    where (status == case_done) status = case_misfit
    if (.not. allocated(error)) call file%check(nf90_put_var(file%id, variable, status), error)
  end subroutine put_status

  subroutine put_comparison(file, findings, error)
    !! The lines beside the modes.
    type(study_file), intent(in) :: file
    type(model_findings), intent(in) :: findings
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: along, each
    real(dp), allocatable :: values(:, :, :)
    integer :: id, peaks, c, n
    if (allocated(error)) return
    each = ''
    if (nf90_inq_dimid(file%id, 'case', id) == nf90_noerr) each = 'case'
    call file%check(nf90_inq_dimid(file%id, 'peak', id), error)
    if (.not. allocated(error)) call file%check(nf90_inquire_dimension(file%id, id, len=peaks), error)
    if (allocated(error)) return
    along = trim(adjustl(each//' peak'))
    allocate (values(peaks, size(findings%cases), 5), source=missing)
    values(:, :, 1) = 0
    do c = 1, size(findings%cases)
      associate (compared => findings%cases(c))
        n = size(compared%mode)
        values(:n, c, 1) = compared%mode
        values(:n, c, 2) = compared%frequency
        values(:n, c, 3) = compared%decay
        values(:n, c, 4) = compared%frequency_misfit
        values(:n, c, 5) = compared%decay_misfit
      end associate
    end do
    call file%put_counts('peak_mode', along, 'mode that the line is taken for; 0: none', &
                         nint(reshape(values(:, :, 1), [size(values(:, :, 1))])), error)
    call file%put_numbers('modelled_angular_frequency', along, 'rad s-1', 'angular frequency of that mode, were it damped as '// &
                          'the line is', flat(2), error)
    call file%put_numbers('modelled_decay_rate', along, 's-1', 'rate of decay of that mode', flat(3), error)
    call file%put_numbers('frequency_misfit', along, '1', 'measured less modelled angular frequency over half its interval', &
                          flat(4), error)
    call file%put_numbers('decay_misfit', along, '1', 'measured less modelled rate of decay over half its interval', flat(5), error)
    if (size(findings%misfits) == 1) each = ''
    associate (misfits => findings%misfits)
      call file%put_numbers('misfit', each, '1', 'chi squared of the lines'' frequencies, and of lines that are taken for no '// &
                            'modes', misfits%chi_squared, error)
      call file%put_counts('misfit_freedom', each, 'degrees of freedom of it', misfits%freedom, error)
      call file%put_numbers('misfit_probability', each, '1', 'probability that noise alone makes more of it', misfits%tail, error)
      call file%put_numbers('model_scatter', each, '1', 'relative error of modelled frequencies beside noise', misfits%scatter, &
                            error)
    end associate
  contains
    pure function flat(i)
      integer, intent(in) :: i
      real(dp) :: flat(size(values, 1)*size(values, 2))
      flat = reshape(values(:, :, i), shape(flat))
    end function flat
  end subroutine put_comparison

  subroutine put_identified(file, found, error)
    !! The unknowns.
    type(study_file), intent(inout) :: file
    type(identification), intent(in) :: found
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: half(size(found%values))
    integer :: n
    n = size(found%values)
    half = 0.5_dp*(found%high - found%low)
    where (is_missing(found%low) .or. is_missing(found%high)) half = missing
    call file%put_axis('unknown_too', n, 'number of the unknown, as unknown', error)
    call put_names(file, 'identified_parameter', 'input that the unknown is', padded(found, .true.), error)
    call put_names(file, 'identified_unit', 'unit of the unknown', padded(found, .false.), error)
    call file%put_numbers('identified', 'unknown', '1', 'value of the unknown, in its unit', found%values, error)
    call file%put_numbers('identified_error', 'unknown', '1', 'half its interval', half, error)
    call file%put_numbers('identified_first', 'unknown', '1', 'least value that it may have', found%unknowns%first, error)
    call file%put_numbers('identified_last', 'unknown', '1', 'largest value that it may have', found%unknowns%last, error)
    call file%put_numbers('identified_low', 'unknown', '1', 'lower end of its interval', found%low, error)
    call file%put_numbers('identified_high', 'unknown', '1', 'upper end of its interval', found%high, error)
    call file%put_numbers('identified_correlation', 'unknown unknown_too', '1', 'correlation of two unknowns', &
                          reshape(found%belief%correlation, [n*n]), error)
  end subroutine put_identified

  pure function padded(found, of_parameters) result(names)
    !! The names of unknowns, or their units, with blanks behind them.
    type(identification), intent(in) :: found
    logical, intent(in) :: of_parameters
    character(:), allocatable :: names(:)
    integer :: i, longest
    longest = 1
    do i = 1, size(found%unknowns)
      longest = max(longest, len(found%unknowns(i)%parameter), len(found%unknowns(i)%unit))
    end do
    allocate (character(longest) :: names(size(found%unknowns)))
    do i = 1, size(names)
      names(i) = found%unknowns(i)%unit
      if (of_parameters) names(i) = found%unknowns(i)%parameter
    end do
  end function padded

  subroutine put_names(file, name, long_name, names, error)
    !! A variable of texts.
    type(study_file), intent(in) :: file
    character(*), intent(in) :: name, long_name, names(:)
    type(error_type), allocatable, intent(inout) :: error
    character(*), parameter :: letters = 'parameter_letter'
    integer :: variable, id
    if (allocated(error)) return
    if (nf90_inq_dimid(file%id, letters, id) /= nf90_noerr) call file%add_dimension(letters, len(names), error)
    call file%check(nf90_def_var(file%id, name, nf90_char, file%dimension_ids('unknown '//letters), variable), error)
    call file%put_text('long_name', long_name, error, variable)
    call file%put_text('_Encoding', 'utf-8', error, variable)
    if (.not. allocated(error)) call file%check(nf90_put_var(file%id, variable, names), error)
  end subroutine put_names

  subroutine read_attribute(path, name, text)
    !! A global attribute of a file; empty where it has none, or cannot be read.
    character(*), intent(in) :: path, name
    character(:), allocatable, intent(out) :: text
    type(child_process) :: child
    type(string), allocatable :: texts(:)
    type(error_type), allocatable :: error
    logical :: whole
    integer :: file, status
    call child%begin(most_seconds)
    if (child%is_here()) then
      call open_netcdf(path, file, status)
      call read_text(file, of_the_file, name, text, status)
      call close_netcdf(file)
      call append(texts, text)
      call child%tell(texts, error)
    end if
    call child%hear(texts, whole, error)
    text = ''
    if (.not. allocated(error)) text = texts(1)%text
  end subroutine read_attribute

end module bw_model_file
