module bw_model_file
  !! The variables of a beam's comparison and identification in the result of its record.
  use bw_case_result, only: case_done, case_misfit
  use bw_classic_reader, only: classic_reader
  use bw_descriptors, only: close_file, look_at_open, open_file, to_read
  use bw_files, only: path_state
  use bw_fit_search, only: misfit_type
  use bw_identification, only: identification
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_model_comparison, only: compared_lines
  use bw_number_file, only: whole_width
  use bw_result_table, only: result_table, unit_of_sensors
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: model_rows, put_misfit, read_attribute

  type, public :: model_findings
    !! All values that are written.
    type(compared_lines), allocatable :: cases(:)        !! of the scene, (cases)
    type(misfit_type), allocatable :: misfits(:)         !! one of all cases fitted together, else of each
    type(identification), allocatable :: found           !! unallocated if nothing was identified
    type(string), allocatable :: scenes(:)               !! texts of the identified scenes: first the scene's own
  contains
    procedure :: trusted
  end type model_findings

contains

  pure logical function trusted(self)
    !! Return whether identified values, if any, explain the lines.
    class(model_findings), intent(in) :: self
    trusted = .true.
    if (allocated(self%found)) trusted = self%found%explained
  end function trusted

  subroutine put_misfit(draft)
    !! Set the status of cases whose lines the identified beam does not explain.
    class(result_table), intent(inout) :: draft
    integer(i8) :: c
    integer :: status
    real(dp), allocatable :: ended(:)
    status = draft%variable('case_status')
    do c = 1, max(1, draft%layout%cases)
      ended = draft%get('case_status', c)
      if (nint(ended(1)) == case_done) call draft%file%put_numbers(draft%place_of(status, c), whole_width, [real(case_misfit, dp)])
    end do
  end subroutine put_misfit

  subroutine model_rows(table, is_identified, findings)
    !! Define or put the modes beside the lines, and the unknowns.
    class(result_table), intent(inout) :: table
    logical, intent(in) :: is_identified                 !! unknowns are identified, from all cases together
    type(model_findings), intent(in), optional :: findings     !! absent while rows are defined
    character(:), allocatable :: each, along             ! dimensions
    each = ''
    if (table%layout%cases > 0) each = 'case'
    along = trim(adjustl(each//' peak'))
    if (is_identified) each = ''
    if (table%whole_row('peak_mode', along, 'mode assigned to the line; 0: none')) &
      call table%put_columns(line_values(1, 0.0_dp))
    if (table%real_row('modelled_angular_frequency', along, 'rad s-1', &
                       'angular frequency of that mode, with the damping of the line')) &
      call table%put_columns(line_values(2, missing))
    if (table%real_row('modelled_decay_rate', along, 's-1', 'rate of decay of that mode')) &
      call table%put_columns(line_values(3, missing))
    if (table%real_row('frequency_misfit', along, '1', 'measured minus modelled angular frequency over half its interval')) &
      call table%put_columns(line_values(4, missing))
    if (table%real_row('decay_misfit', along, '1', 'measured minus modelled rate of decay over half its interval')) &
      call table%put_columns(line_values(5, missing))
    if (table%real_row('modelled_shape', along//' profile', '1', 'shape of that mode along the beam, as the sensors measure it')) &
      call table%put_columns(line_shapes())
    if (answer('real', 'response to a hammer''s force by the model, real part')) call table%put_columns(responses(.false.))
    if (answer('imag', 'its imaginary part')) call table%put_columns(responses(.true.))
    if (table%real_row('misfit', each, '1', 'chi squared of the lines'' frequencies, and of lines that are assigned to no mode')) &
      call table%put(findings%misfits%chi_squared)
    if (table%whole_row('misfit_freedom', each, 'degrees of freedom of it')) call table%put(findings%misfits%freedom)
    if (table%real_row('misfit_probability', each, '1', 'probability that noise alone exceeds it')) &
      call table%put(findings%misfits%tail)
    if (table%real_row('model_scatter', each, '1', 'relative error of modelled frequencies beyond noise')) &
      call table%put(findings%misfits%scatter)
    if (is_identified) call identified_rows(table, findings)
  contains
    logical function answer(part, long_name)
      character(*), intent(in) :: part, long_name
      answer = table%real_row('modelled_response_'//part, trim(adjustl(each//' point frequency')), unit_of_sensors//' N-1', &
                              long_name, needs='hammer places')
    end function answer
    function responses(imaginary) result(values)
      !! Return values of each sensor, and of each case unless all share one beam, (frequencies, sensors·cases).
      logical, intent(in) :: imaginary
      real(dp), allocatable :: values(:, :)
      integer :: c, n
      n = table%layout%points
      allocate (values(size(findings%cases(1)%response, 1), n*merge(1, size(findings%cases), is_identified)))
      do c = 1, size(values, 2)/n
        if (imaginary) values(:, (c - 1)*n + 1:c*n) = findings%cases(c)%response%im
        if (.not. imaginary) values(:, (c - 1)*n + 1:c*n) = findings%cases(c)%response%re
      end do
    end function responses
    function line_shapes() result(values)
      !! Return shapes of each line of each case, (places, peaks·cases).
      real(dp), allocatable :: values(:, :)
      integer :: c, n
      allocate (values(table%layout%profile, table%layout%peaks*size(findings%cases)), source=missing)
      do c = 1, size(findings%cases)
        n = size(findings%cases(c)%shape, 2)
        values(:, (c - 1)*table%layout%peaks + 1:(c - 1)*table%layout%peaks + n) = findings%cases(c)%shape
      end do
    end function line_shapes
    function line_values(which, none) result(values)
      !! Return values of each line of each case, (peaks, cases).
      integer, intent(in) :: which
      real(dp), intent(in) :: none
      real(dp), allocatable :: values(:, :)
      integer :: c, n
      allocate (values(table%layout%peaks, size(findings%cases)), source=none)
      do c = 1, size(findings%cases)
        associate (compared => findings%cases(c))
          n = size(compared%mode)
          select case (which)
          case (1); values(:n, c) = compared%mode
          case (2); values(:n, c) = compared%frequency
          case (3); values(:n, c) = compared%decay
          case (4); values(:n, c) = compared%frequency_misfit
          case (5); values(:n, c) = compared%decay_misfit
          end select
        end associate
      end do
    end function line_values
  end subroutine model_rows

  subroutine identified_rows(table, findings)
    !! Define or put the unknowns.
    class(result_table), intent(inout) :: table
    type(model_findings), intent(in), optional :: findings
    type(string), allocatable :: names(:), units(:)
    integer :: i
    if (present(findings)) then
      do i = 1, size(findings%found%unknowns)
        call append(names, findings%found%unknowns(i)%parameter)
        call append(units, findings%found%unknowns(i)%unit)
      end do
    end if
    if (table%text_row('identified_parameter', 'unknown parameter_letter', 'input that the unknown is')) &
      call table%put_texts(names)
    if (table%text_row('identified_unit', 'unknown parameter_letter', 'unit of the unknown')) call table%put_texts(units)
    if (row('', 'value of the unknown, in its unit')) call table%put(findings%found%values)
    if (row('_error', 'half its interval')) call table%put(half_of(findings%found%low, findings%found%high))
    if (row('_first', 'least value that it may have')) call table%put(findings%found%unknowns%first)
    if (row('_last', 'largest value that it may have')) call table%put(findings%found%unknowns%last)
    if (row('_low', 'lower end of its interval')) call table%put(findings%found%low)
    if (row('_high', 'upper end of its interval')) call table%put(findings%found%high)
    if (table%real_row('identified_correlation', 'unknown unknown_too', '1', 'correlation of two unknowns')) &
      call table%put_columns(findings%found%uncertainty%correlation)
  contains
    logical function row(ending, long_name)
      character(*), intent(in) :: ending, long_name
      row = table%real_row('identified'//ending, 'unknown', '1', long_name)
    end function row
  end subroutine identified_rows

  elemental real(dp) function half_of(low, high) result(half)
    !! Return half an interval; missing if an end is.
    real(dp), intent(in) :: low, high
    half = missing
    if (.not. (is_missing(low) .or. is_missing(high))) half = 0.5_dp*(high - low)
  end function half_of

  subroutine read_attribute(path, name, text)
    !! Read a text attribute of a result; empty if it is absent or cannot be read.
    character(*), intent(in) :: path, name
    character(:), allocatable, intent(out) :: text
    type(classic_reader) :: reader
    type(path_state) :: state
    character(:), allocatable :: start
    integer :: descriptor, problem, ignored
    text = ''
    if (open_file(path, to_read, descriptor) /= 0) return
    problem = look_at_open(descriptor, state)
    if (problem == 0) call reader%read_file(descriptor, state%bytes, '', start, problem)
    ignored = close_file(descriptor)
    if (problem == 0 .and. reader%is_sound) text = reader%text_of(name)
  end subroutine read_attribute

end module bw_model_file
