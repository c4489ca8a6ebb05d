module spectrum_numbers
  !! Bounds on the frequencies found in random records, against the frequencies that were put in.
  use bw_kinds, only: dp
  use line_records, only: judge_records, verdict_type
  use number_table, only: table_type
  implicit none (type, external)
  private
  public :: measure_spectrum

contains

  subroutine measure_spectrum(table)
    type(table_type), intent(inout) :: table
    type(verdict_type) :: verdict
    verdict = judge_records(500)
    call table%begin('spectrum of 500 random records of 2 to 10 lines', 0.0_dp, &
                     'peaks whose bound is below the true error')
    call table%note_many(real(verdict%violations, dp), verdict%peaks)
    call table%begin('pairs of lines closer than 1/T in these records', 0.05_dp, 'part of the pairs that are not named')
    call table%note_many(1.0_dp - real(verdict%named, dp)/verdict%pairs, verdict%pairs)
  end subroutine measure_spectrum

end module spectrum_numbers
